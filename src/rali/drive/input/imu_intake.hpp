#pragma once

#include <optional>

#include "rali/drive/input/imu_check.hpp"
#include "rali/drive/input/input_report.hpp"
#include "rali/sensor/imu_sample.hpp"

namespace rali::drive {

/// Converts samples of the file to samples for the odometry: SI units, checked. They stay in the
/// IMU frame, where the odometry needs no lever arm.
class ImuIntake {
 public:
  explicit ImuIntake(const ImuUnits& units) : units_(units) {}

  /// @return empty for a sample that is not finite or implausible; counted in `gaps`
  [[nodiscard]] std::optional<sensor::ImuSample> take(const sensor::ImuSample& raw,
                                                      InputGaps& gaps);

 private:
  void count_saturation(const sensor::ImuSample& si, InputGaps& gaps);

  ImuUnits units_;
  geometry::Vec3 last_accel_ = geometry::Vec3::Zero(), last_gyro_ = geometry::Vec3::Zero();
  geometry::Vec3 max_accel_ = geometry::Vec3::Zero(), max_gyro_ = geometry::Vec3::Zero();
};

/// True if all six values are finite and possible for an inertial sensor, in any of its units.
[[nodiscard]] bool is_plausible(const sensor::ImuSample& raw);

}  // namespace rali::drive
