#pragma once

#include <memory>

#include "rali/odometry/odometry.hpp"
#include "rali/odometry/settings.hpp"

namespace rali::odometry {

/// Makes the odometry that the settings select. @param has_imu false: constant velocity.
[[nodiscard]] std::unique_ptr<Odometry> make_odometry(const OdometrySettings& settings,
                                                      const sensor::Calibration& calibration,
                                                      bool has_imu);

}  // namespace rali::odometry
