#pragma once

#include <memory>

#include "rali/odometry/odometry.hpp"
#include "rali/odometry/settings.hpp"

namespace rali::odometry {

/// Preset `paper`: the paper's LiDAR-inertial odometry, each ambiguity of its text a setting.
/// Without IMU the initial guess is constant velocity. Interpretations of the text are listed in
/// docs/explain/math/paper_odometry.md.
[[nodiscard]] std::unique_ptr<Odometry> make_paper_odometry(const OdometrySettings& settings,
                                                            const sensor::Calibration& calibration,
                                                            bool has_imu);

}  // namespace rali::odometry
