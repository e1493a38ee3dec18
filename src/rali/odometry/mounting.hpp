#pragma once

#include "rali/geometry/se3.hpp"

namespace rali::odometry {

/// Pose error from a small rotation of the LiDAR against T_body_lidar: the whole path is rotated by
/// it about its first pose, at 50 m by 9 cm for 0.1 deg. The map is not affected.
/// @param T_odom_first of the body at the start of the path @param sigma_rad about each axis
/// @return covariance of geometry::boxplus
[[nodiscard]] geometry::Mat6 mounting_covariance(const geometry::SE3& T_odom_first,
                                                 const geometry::SE3& T_odom_body,
                                                 double sigma_rad);

}  // namespace rali::odometry
