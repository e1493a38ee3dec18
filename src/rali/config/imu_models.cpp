#include "rali/config/imu_models.hpp"

#include <array>
#include <string_view>

namespace rali::config {
namespace {

constexpr double kMicroG = 9.80665e-6;  // m/s^2
constexpr double kRadPerDeg = 3.14159265358979323846 / 180.0;

struct ImuModel {
  std::string_view name;
  double accel_ug_rthz;  // unit of data sheets
  double gyro_dps_rthz;
};

// White noise of the data sheets. Only the MTi-1 was read there; the others are to be checked. Data
// sheets do not state a bias random walk: all models use the odometry's defaults.
constexpr std::array kModels{
    ImuModel{"xsens_mti_30", 60.0, 0.03},
    ImuModel{"xsens_mti_1", 120.0, 0.007},
    ImuModel{"vn_100", 140.0, 0.0035},
    ImuModel{"bmi088", 175.0, 0.014},
    ImuModel{"icm20948", 230.0, 0.015},
    ImuModel{"mid360", 70.0, 0.0045},  // ICM-40609 inside the Mid-360
};

odometry::ImuNoiseSettings noise_of_model(const std::string& name) {
  odometry::ImuNoiseSettings noise;  // generic_mems
  for (const ImuModel& model : kModels) {
    if (model.name != name) continue;
    noise.accel_mps2_rthz = model.accel_ug_rthz * kMicroG;
    noise.gyro_radps_rthz = model.gyro_dps_rthz * kRadPerDeg;
  }
  return noise;
}

}  // namespace

std::vector<std::string> imu_model_names() {
  std::vector<std::string> names{"generic_mems"};
  for (const ImuModel& model : kModels) names.emplace_back(model.name);
  return names;
}

odometry::ImuNoiseSettings imu_noise_of(const ImuConfig& imu) {
  odometry::ImuNoiseSettings noise = noise_of_model(imu.model);
  noise.accel_mps2_rthz = imu.noise.accel_mps2_rthz.value_or(noise.accel_mps2_rthz);
  noise.gyro_radps_rthz = imu.noise.gyro_radps_rthz.value_or(noise.gyro_radps_rthz);
  noise.accel_walk_mps3_rthz = imu.noise.accel_walk_mps3_rthz.value_or(noise.accel_walk_mps3_rthz);
  noise.gyro_walk_radps2_rthz =
      imu.noise.gyro_walk_radps2_rthz.value_or(noise.gyro_walk_radps2_rthz);
  noise.vibration_factor = imu.vibration_factor.value_or(noise.vibration_factor);
  return noise;
}

}  // namespace rali::config
