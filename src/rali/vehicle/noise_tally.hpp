#pragma once

#include "rali/imu/motion_noise.hpp"

namespace rali::vehicle {

/// Noise of the inertial data over a drive: the geometric mean over the scans in which it was
/// measured.
class NoiseTally {
 public:
  void add(const imu::MeasuredNoise& now);

  /// Empty where it never was measured.
  [[nodiscard]] imu::MeasuredNoise mean() const;

 private:
  struct LogMean {
    double sum = 0.0;
    int n = 0;
  };

  LogMean gyro_, accel_;
};

}  // namespace rali::vehicle
