#pragma once

#include "rali/base/settings.hpp"

namespace rali::ranging {

/// How good a range is, and what cannot be one (algorithms 4.1, 4.3).
struct RangeLimits {
  double near_m = 0.3;   ///< below: no direction, near field
  double far_m = 300.0;  ///< no such radio reaches farther
  double sigma_m = 0.10;
  double sigma_per_m = 0.001;
  double sigma_min_m = 0.01;   ///< a recording that claims less is not believed
  double speed_max_mps = 6.0;  ///< of the two ends against each other

  template <class V>
  void visit(V& v) {
    v("near_m", near_m, 0.0, 10.0, "shorter ranges are left out");
    v("far_m", far_m, 1.0, 10000.0, "longer ranges are left out");
    v("sigma_m", sigma_m, 0.001, 10.0, "sigma of a range in line of sight");
    v("sigma_per_m", sigma_per_m, 0.0, 0.1, "and per metre of it, added in squares");
    v("sigma_min_m", sigma_min_m, 1e-4, 1.0, "least sigma believed of a recorded range");
    v("speed_max_mps", speed_max_mps, 0.1, 100.0, "how fast a range can change");
  }
};

/// Settings of room ranging.
struct RangingSettings {
  bool use = true;  ///< false: ranges are read and reported, nothing more
  RangeLimits limits;

  template <class V>
  void visit(V& v) {
    v("use", use, "ranges move the poses; false: they are only reported");
    v.group("limits", limits, "what can be a range");
  }
};

}  // namespace rali::ranging
