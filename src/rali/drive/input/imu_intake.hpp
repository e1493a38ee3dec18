#pragma once

#include <optional>

#include "rali/drive/input/imu_check.hpp"
#include "rali/drive/input/input_report.hpp"
#include "rali/sensor/imu_sample.hpp"

namespace rali::drive {

/// Turns samples as they are in the file into samples the odometry takes: SI units, body frame,
/// checked. With a lever arm r of the IMU the centripetal part w x (w x r) is taken off; the part
/// of the angular acceleration is not (0.1 m/s^2 at 1 rad/s^2 and 0.1 m: below vibration), since
/// differentiating the gyro would add more noise than it removes.
class ImuIntake {
 public:
  ImuIntake(const ImuUnits& units, const geometry::SE3& T_body_imu)
      : units_(units), T_body_imu_(T_body_imu) {}

  /// @return empty for a sample that is no number or absurd; counted in `gaps`
  [[nodiscard]] std::optional<sensor::ImuSample> take(const sensor::ImuSample& raw,
                                                      InputGaps& gaps);

 private:
  void count_saturation(const sensor::ImuSample& si, InputGaps& gaps);

  ImuUnits units_;
  geometry::SE3 T_body_imu_;
  geometry::Vec3 last_accel_ = geometry::Vec3::Zero(), last_gyro_ = geometry::Vec3::Zero();
  geometry::Vec3 most_accel_ = geometry::Vec3::Zero(), most_gyro_ = geometry::Vec3::Zero();
};

/// True if all six values are numbers that an inertial sensor can give, in any of its units.
[[nodiscard]] bool is_plausible(const sensor::ImuSample& raw);

}  // namespace rali::drive
