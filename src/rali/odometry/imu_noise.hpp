#pragma once

#include "rali/base/settings.hpp"
#include "rali/imu/motion_noise.hpp"

namespace rali::odometry {

/// IMU noise in data-sheet units (users.md section 4) and the factor that driving adds to it.
struct ImuNoiseSettings {
  double gyro_radps_rthz = 1e-3;
  double accel_mps2_rthz = 1e-2;
  double gyro_walk_radps2_rthz = 1e-5;
  double accel_walk_mps3_rthz = 1e-4;
  double vibration_factor = 3.0;

  template <class V>
  void visit(V& v) {
    v("gyro_radps_rthz", gyro_radps_rthz, 1e-7, 1.0, "gyro white noise, data sheet [rad/s/rtHz]");
    v("accel_mps2_rthz", accel_mps2_rthz, 1e-6, 10.0, "accelerometer white noise [m/s2/rtHz]");
    v("gyro_walk_radps2_rthz", gyro_walk_radps2_rthz, 0.0, 1.0, "gyro bias walk [rad/s2/rtHz]");
    v("accel_walk_mps3_rthz", accel_walk_mps3_rthz, 0.0, 10.0,
      "accelerometer bias walk [m/s3/rtHz]");
    v("vibration_factor", vibration_factor, 1.0, 100.0, "white noise while driving / data sheet");
  }
};

/// White noise of a driving vehicle, from the settings.
[[nodiscard]] inline imu::NoiseDensity driving_noise(const ImuNoiseSettings& s) {
  return {s.vibration_factor * s.gyro_radps_rthz, s.vibration_factor * s.accel_mps2_rthz};
}

}  // namespace rali::odometry
