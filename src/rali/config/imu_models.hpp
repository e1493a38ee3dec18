#pragma once

#include <string>
#include <vector>

#include "rali/config/fleet_config.hpp"

namespace rali::config {

/// Names that vehicles.*.imu.model takes.
[[nodiscard]] std::vector<std::string> imu_model_names();

/// The noise of one vehicle's IMU: `settings.odometry.imu_noise` where it was given, else the
/// vehicle's `imu.noise` and `imu.vibration_factor`, else the data sheet of `imu.model`.
[[nodiscard]] odometry::ImuNoiseSettings imu_noise_of(const FleetConfig& fleet,
                                                      const VehicleConfig& vehicle);

}  // namespace rali::config
