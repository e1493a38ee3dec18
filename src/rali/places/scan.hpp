#pragma once

#include <cstddef>
#include <span>

#include "rali/base/ids.hpp"
#include "rali/geometry/se3.hpp"

namespace rali::places {

/// Points of one keyframe as this module uses them: in the body frame, undistorted, thinned to
/// about 0.2 m. A view: the spans have equal length and are valid during the call only.
struct Scan {
  KeyframeId id;
  geometry::SE3 T_body_lidar;                        ///< ray origins
  geometry::Vec3 up_body = geometry::Vec3::UnitZ();  ///< against gravity, unit
  std::span<const float> x_m, y_m, z_m;

  [[nodiscard]] std::size_t size() const { return x_m.size(); }

  [[nodiscard]] geometry::Vec3 point_body(std::size_t i) const {
    return {static_cast<double>(x_m[i]), static_cast<double>(y_m[i]), static_cast<double>(z_m[i])};
  }
};

/// A scan and its pose, in any frame that is common to the scans of one submap.
struct PosedScan {
  Scan scan;
  geometry::SE3 T_odom_body;
};

}  // namespace rali::places
