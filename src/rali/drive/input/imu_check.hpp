#pragma once

#include <span>
#include <string>

#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"
#include "rali/drive/input/input_report.hpp"
#include "rali/sensor/imu_sample.hpp"

namespace rali::drive {

/// Statistics of an interval of inertial data, in the units of the file.
struct ImuStretch {
  geometry::Vec3 accel_mean = geometry::Vec3::Zero();
  geometry::Vec3 gyro_mean = geometry::Vec3::Zero();
  double accel_norm_median = 0.0;
  double accel_std_fraction = 0.0;  ///< spread of |a| / |a|
  double gyro_noise = 0.0;          ///< from sample to sample, largest of the three axes
  Time t_start, t_end;
  bool at_rest = false;  ///< according to both sensors, in any unit
};

/// The half second of the samples with the least noise (or all, if shorter): a standstill, if there
/// is one. A smooth turn hardly disturbs the accelerometer, so the gyro's means over 0.1 s must
/// agree, too.
[[nodiscard]] ImuStretch quietest_stretch(std::span<const sensor::ImuSample> samples);

/// Factors to m/s^2 and rad/s.
struct ImuUnits {
  double accel_scale = 1.0;
  double gyro_scale = 1.0;
  FindingList findings;  ///< D08, D09
};

/// Determines the units by value: |a| near 1 is g, near 9.8 is m/s^2. A gyro is in degrees if its
/// noise at rest, steady rate or rate while driving is impossible in rad/s. A rate that may be a
/// bias in deg/s or a steady turn in rad/s is left as rad/s and reported. Source: users.md U11;
/// LIO_SAM_6AXIS#91, livox_ros_driver#63. Errors: kInput if gravity was removed from the data (|a|
/// near 0), since nothing can be levelled.
[[nodiscard]] Result<ImuUnits> decide_imu_units(std::span<const sensor::ImuSample> first,
                                                const InputOptions& options,
                                                const std::string& topic);

/// Compares the rotation of the gyro with the LiDAR's over the run: a ratio near 57.3 is deg/s read
/// as rad/s. A total rotation of less than 0.2 rad is not evaluated.
class GyroRatio {
 public:
  void add_gyro(double angle_rad) { gyro_rad_ += angle_rad; }

  void add_lidar(double angle_rad) { lidar_rad_ += angle_rad; }

  /// Gyro / LiDAR; 0 until the rotation suffices.
  [[nodiscard]] double ratio() const;

 private:
  double gyro_rad_ = 0.0, lidar_rad_ = 0.0;
};

}  // namespace rali::drive
