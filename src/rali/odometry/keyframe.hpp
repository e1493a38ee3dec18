#pragma once

#include <cstdint>
#include <vector>

#include "rali/base/time.hpp"
#include "rali/geometry/se3.hpp"

namespace rali::odometry {

/// Deskewed points of one scan in the body frame at the time of the keyframe.
struct KeyframeCloud {
  std::vector<float> x_m, y_m, z_m;
  std::vector<float> intensity;
  std::vector<std::uint16_t> ring;

  [[nodiscard]] std::size_t size() const { return x_m.size(); }
};

/// A scan kept for the map. Immutable once made.
struct Keyframe {
  Time t;                     ///< time of its last point; all points refer to it
  geometry::SE3 T_odom_body;  ///< as estimated when it was made
  geometry::Mat6 covariance = geometry::Mat6::Zero();  ///< of geometry::boxplus
  /// Relative to the previous keyframe: pose T_previous_this and the joint information of LiDAR and
  /// IMU (6x6, rotation and translation in the previous body), 0 for the first.
  geometry::SE3 T_previous_this;
  geometry::Mat6 information_relative = geometry::Mat6::Zero();
  geometry::SE3 T_body_lidar;  ///< origin of the rays, for free space
  KeyframeCloud cloud;
};

}  // namespace rali::odometry
