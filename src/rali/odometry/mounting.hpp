#pragma once

#include "rali/geometry/se3.hpp"

namespace rali::odometry {

/// What a pose is wrong by because the LiDAR is mounted turned by a little against T_body_lidar:
/// the whole path is turned by as much about its first pose, at 50 m by 9 cm for 0.1 deg. The map
/// is as good as ever.
/// @param T_odom_first of the body, where the path begins  @param sigma_rad about each axis
/// @return covariance of geometry::boxplus
[[nodiscard]] geometry::Mat6 mounting_covariance(const geometry::SE3& T_odom_first,
                                                 const geometry::SE3& T_odom_body,
                                                 double sigma_rad);

}  // namespace rali::odometry
