#pragma once

#include <memory>

#include "rali/odometry/odometry.hpp"
#include "rali/odometry/settings.hpp"

namespace rali::odometry {

/// Preset `robust`: tightly coupled iterated error-state filter over probabilistic voxel planes
/// (algorithms 2.2 to 2.7). Without inertial data, and until gravity is known, at constant
/// velocity.
/// @param forward_body unit vector along which the vehicle drives; the body frame of the filter is
/// that of the IMU
[[nodiscard]] std::unique_ptr<Odometry> make_robust_odometry(
    const OdometrySettings& settings, const sensor::Calibration& calibration, bool has_imu,
    const geometry::Vec3& forward_body = geometry::Vec3::UnitX());

}  // namespace rali::odometry
