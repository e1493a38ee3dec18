#pragma once

#include "rali/base/settings.hpp"

namespace rali::degeneracy {

/// How to treat the sign of the normals, which a single plane leaves ambiguous (finding F4).
enum class NormalSign {
  kGiven,  ///< as the odometry delivers them (its setting paper.normal_sign: sensor or raw)
  kFree    ///< second moment without mean: n and -n count alike
};
inline constexpr ChoiceNames<2> kNormalSignNames{"given", "free"};

/// The eigenvalues whose ratio is the degree.
enum class DegreeRatio {
  kL2L3,  ///< of the covariance, l1 >= l2 >= l3; as printed
  kL1L3,
  kL1L2,
  kHorizontal  ///< of its horizontal 2x2 block, h1 >= h2: h1/h2
};
inline constexpr ChoiceNames<4> kDegreeRatioNames{"l2_l3", "l1_l3", "l1_l2", "horizontal"};

/// The direction that is taken as degenerate.
enum class DegreeDirection {
  kE3Xy,  ///< e3 projected on the horizontal plane; none if the projection is shorter than 0.5
  kE3,    ///< e3 as it is
  kMinHorizontal  ///< smallest eigenvector of the horizontal 2x2 block
};
inline constexpr ChoiceNames<3> kDegreeDirectionNames{"e3_xy", "e3", "min_horizontal"};

/// The paper's detector: each ambiguity of its text is a setting (algorithms.md table 0.2).
struct PaperDegreeSettings {
  NormalSign normal_sign = NormalSign::kGiven;
  DegreeRatio deg_ratio = DegreeRatio::kHorizontal;
  double deg_below = 0.0;
  double deg_above = 150.0;
  DegreeDirection deg_direction = DegreeDirection::kMinHorizontal;
  int deg_min_normals = 50;

  template <class V>
  void visit(V& v) {
    v.choice("normal_sign", normal_sign, kNormalSignNames,
             "given: covariance of the normals; free: second moment, sign does not matter");
    v.choice("deg_ratio", deg_ratio, kDegreeRatioNames, "eigenvalues that make the degree");
    v("deg_below", deg_below, 0.0, 1e6, "degenerate if the degree is below; 0 switches it off");
    v("deg_above", deg_above, 0.0, 1e6, "degenerate if the degree is above; 0 switches it off");
    v.choice("deg_direction", deg_direction, kDegreeDirectionNames,
             "which direction is degenerate");
    v("deg_min_normals", deg_min_normals, 0, 100000, "with fewer normals the degree is unknown");
  }

  /// The settings with the odometry's `literal` replaced by the readings that it selects.
  [[nodiscard]] PaperDegreeSettings resolved(bool literal) const {
    PaperDegreeSettings out = *this;
    if (!literal) return out;
    out.normal_sign = NormalSign::kGiven;
    out.deg_ratio = DegreeRatio::kL2L3;
    out.deg_below = 3.0;
    out.deg_above = 0.0;
    out.deg_direction = DegreeDirection::kE3Xy;
    return out;
  }
};

}  // namespace rali::degeneracy
