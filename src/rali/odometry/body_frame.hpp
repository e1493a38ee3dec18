#pragma once

#include <memory>

#include "rali/odometry/odometry.hpp"

namespace rali::odometry {

/// Runs an odometry in the frame of the IMU, where its samples need no lever arm, and reports in
/// the body frame. `inner` must have been made with imu_calibration(). Odom has its origin and
/// heading at the body's first pose.
[[nodiscard]] std::unique_ptr<Odometry> in_body_frame(std::unique_ptr<Odometry> inner,
                                                      const geometry::SE3& T_body_imu);

/// The calibration as seen from the IMU: T_imu_lidar in place of T_body_lidar.
[[nodiscard]] sensor::Calibration imu_calibration(const sensor::Calibration& calibration);

}  // namespace rali::odometry
