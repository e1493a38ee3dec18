#pragma once

#include <memory>

#include "rali/odometry/odometry.hpp"
#include "rali/odometry/settings.hpp"

namespace rali::odometry {

/// Preset `robust`: tightly coupled iterated error-state filter over probabilistic voxel planes
/// (algorithms 2.2 to 2.7). Without inertial data, and until gravity is known, at constant
/// velocity.
[[nodiscard]] std::unique_ptr<Odometry> make_robust_odometry(const OdometrySettings& settings,
                                                             const sensor::Calibration& calibration,
                                                             bool has_imu);

}  // namespace rali::odometry
