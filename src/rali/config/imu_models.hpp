#pragma once

#include <string>
#include <vector>

#include "rali/config/fleet_config.hpp"

namespace rali::config {

/// Allowed values of vehicles.*.imu.model.
[[nodiscard]] std::vector<std::string> imu_model_names();

/// The noise of one vehicle's IMU: `noise` and `vibration_factor` where given, else the data sheet
/// of `model`.
[[nodiscard]] odometry::ImuNoiseSettings imu_noise_of(const ImuConfig& imu);

}  // namespace rali::config
