#pragma once

#include <optional>
#include <span>

#include "rali/geometry/types.hpp"
#include "rali/sensor/imu_sample.hpp"

namespace rali::imu {

/// When inertial samples count as standstill (algorithms 1.4).
struct RestSettings {
  double window_s = 1.0;
  double gyro_sd_max_radps = 0.02;
  double accel_sd_max_mps2 = 0.25;
  double gyro_mean_max_radps = 0.05;

  template <class V>
  void visit(V& v) {
    v("window_s", window_s, 0.2, 10.0, "length of a standstill");
    v("gyro_sd_max_radps", gyro_sd_max_radps, 1e-5, 1.0, "spread of each rate at standstill");
    v("accel_sd_max_mps2", accel_sd_max_mps2, 1e-4, 10.0,
      "spread of each acceleration at standstill");
    v("gyro_mean_max_radps", gyro_mean_max_radps, 1e-4, 1.0, "largest mean rate (turn-on bias)");
  }
};

/// Mean and standard deviation of a sequence of inertial samples.
struct ImuStatistics {
  geometry::Vec3 gyro_mean_radps = geometry::Vec3::Zero();
  geometry::Vec3 accel_mean_mps2 = geometry::Vec3::Zero();
  geometry::Vec3 gyro_sd_radps = geometry::Vec3::Zero();
  geometry::Vec3 accel_sd_mps2 = geometry::Vec3::Zero();
  int samples = 0;
  double period_s = 0.0;  ///< mean time between two samples
};

[[nodiscard]] ImuStatistics statistics(std::span<const sensor::ImuSample> samples);

/// True if standard deviations and mean rate are within the limits of standstill.
[[nodiscard]] bool is_rest(const ImuStatistics& stats, const RestSettings& settings);

/// Rotation R_odom_body with zero yaw that turns the mean specific force to +z (T5).
[[nodiscard]] geometry::Mat3 level(const geometry::Vec3& accel_mean_mps2);

}  // namespace rali::imu
