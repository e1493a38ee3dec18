#pragma once

// A synthetic motion for tests of imu and the layers above: the same rotation measured by a gyro at
// 200 Hz and by a LiDAR at 10 Hz, each with its errors.

#include <cmath>
#include <vector>

#include "rali/base/rng.hpp"
#include "rali/imu/rotation_study.hpp"

namespace rali::imu::test {

struct TurningPair {
  double duration_s = 60.0;
  double rate_radps = 0.6;    ///< amplitude of the yaw rate
  double tilt_radps = 0.25;   ///< amplitude of the roll and pitch rates; 0 if rate_radps = 0
  double lidar_late_s = 0.0;  ///< LiDAR stamps are later than the true time by this
  double gyro_scale = 1.0;
  geometry::Vec3 gyro_bias_radps = geometry::Vec3::Zero();
  geometry::Mat3 R_imu_lidar = geometry::Mat3::Identity();
  bool mirrored_y = false;  ///< y of the LiDAR driver points right

  /// True rate in the IMU frame.
  [[nodiscard]] geometry::Vec3 rate(double t_s) const {
    const double tilt = rate_radps > 0.0 ? tilt_radps : 0.0;
    return {tilt * std::sin(1.7 * t_s), tilt * std::sin(1.1 * t_s + 0.4),
            rate_radps * std::sin(0.7 * t_s) + 0.3 * rate_radps * std::sin(2.3 * t_s)};
  }

  [[nodiscard]] std::vector<sensor::ImuSample> imu() const {
    std::vector<sensor::ImuSample> samples;
    Rng rng(5, "gyro");
    for (int i = 0; i <= static_cast<int>(duration_s * 200.0); ++i) {
      const double t = i / 200.0;
      const geometry::Vec3 noise{rng.normal(), rng.normal(), rng.normal()};
      const geometry::Vec3 shake{rng.normal(), rng.normal(), rng.normal()};
      samples.push_back({Time::from_s(t), gyro_scale * (rate(t) + gyro_bias_radps + 0.003 * noise),
                         geometry::Vec3{0.0, 0.0, 9.81} + 0.05 * shake});
    }
    return samples;
  }

  [[nodiscard]] std::vector<LidarTurn> lidar() const {
    std::vector<LidarTurn> turns;
    Rng rng(6, "lidar");
    for (int i = 10; i < static_cast<int>(duration_s * 10.0) - 10; ++i) {
      const double begin = i * 0.1;
      geometry::Mat3 R = geometry::Mat3::Identity();
      for (int k = 0; k < 20; ++k) {
        R = R * geometry::so3_exp(rate(begin + (k + 0.5) * 0.005) * 0.005);
      }
      const geometry::Vec3 noise{rng.normal(), rng.normal(), rng.normal()};
      geometry::Vec3 turn = R_imu_lidar.transpose() * geometry::so3_log(R) + 0.001 * noise;
      // A rotation vector is a pseudo-vector: mirroring y flips the signs of x and z.
      if (mirrored_y) turn = geometry::Vec3{-turn.x(), turn.y(), -turn.z()};
      turns.push_back(
          {Time::from_s(begin + lidar_late_s), Time::from_s(begin + 0.1 + lidar_late_s), turn});
    }
    return turns;
  }
};

}  // namespace rali::imu::test
