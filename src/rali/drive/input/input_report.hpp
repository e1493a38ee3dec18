#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/base/ids.hpp"
#include "rali/base/time.hpp"
#include "rali/drive/ranges/range_latency.hpp"
#include "rali/drive/ranges/range_options.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/imu/mounting.hpp"
#include "rali/wire/cloud_format.hpp"

namespace rali::drive {

enum class AccelUnit { kAuto, kMps2, kG };
enum class GyroUnit { kAuto, kRadps, kDegps };

/// How strictly the extrinsics are compared with the data (checks.extrinsics).
enum class ExtrinsicsCheck { kError, kWarn, kOff };

/// The offset added to the LiDAR's stamps, and its origin.
struct LidarTimeOffset {
  double value_s = 0.0;
  std::optional<double> estimate_s, sigma_s;  ///< from the data; empty: not requested, or no result
  std::string origin;                         ///< in words, if estimated or tried; empty: settings
};

/// What is added to all stamps of a vehicle to get those of the fleet, and its origin.
struct ClockOffset {
  double value_s = 0.0;
  std::optional<double> sigma_s;  ///< of the estimate; empty: not requested, or not found
  std::string origin;             ///< in words, if estimated or tried; empty: settings
};

/// What the user fixed about one vehicle's input; everything else is determined from the data.
struct InputOptions {
  std::string vehicle = "v1";
  VehicleId self;
  std::shared_ptr<const RangeOptions> ranges;  ///< of the fleet; null: none are read
  std::string lidar_topic = "auto";
  std::string imu_topic = "auto";  ///< "none": LiDAR only
  wire::CloudFormatOptions cloud;
  AccelUnit accel_unit = AccelUnit::kAuto;
  GyroUnit gyro_unit = GyroUnit::kAuto;
  std::optional<geometry::SE3> T_body_lidar;  ///< empty: auto
  std::string lidar_tf_frame;                 ///< from_tf of T_body_lidar; empty: not requested
  geometry::SE3 T_body_imu;                   ///< used unless imu_from_tf
  bool imu_from_tf = false;                   ///< T_body_imu from /tf_static
  std::string imu_tf_frame;  ///< the IMU's frame there; empty: that of its messages
  LidarTimeOffset lidar_time_offset;
  imu::MountingByTurning mounting;
  /// The mounting will be judged by the turning: until then the ground refuses nothing.
  bool turning_follows = false;
  ClockOffset clock_offset;
  double start_s = 0.0;     ///< after the first event
  double duration_s = 0.0;  ///< 0: to the end
  ExtrinsicsCheck extrinsics = ExtrinsicsCheck::kError;
  bool strict = false;  ///< end at the first damage
};

/// What was missing or dropped in one vehicle's input. Counts of samples unless named otherwise.
struct InputGaps {
  std::uint64_t jumps = 0;        ///< clock jumps that were closed
  double missing_s = 0.0;         ///< time without scans, beyond two scan periods
  double imu_missing_s = 0.0;     ///< time without inertial samples
  std::uint64_t late = 0;         ///< arrived after the ordering window
  std::uint64_t late_scans = 0;   ///< scans among them
  std::uint64_t empty_scans = 0;  ///< without a usable point: missing, like scans that never came
  std::uint64_t repeated = 0;     ///< same stamp as the one before
  std::uint64_t nan_points = 0;
  std::uint64_t no_time_points = 0;  ///< points of scans without point times
  std::uint64_t imu_invalid = 0;     ///< NaN, infinite or absurd inertial samples
  std::uint64_t imu_saturated = 0;   ///< values that repeat the largest value seen, exactly
  std::uint64_t undecodable = 0;     ///< messages or files that could not be read
  std::uint64_t bytes_lost = 0;      ///< after the end of a truncated file
  bool damaged = false;              ///< the run ends with exit code 3
};

/// Everything that was decided about one vehicle's input, for settings.yaml and the report.
struct InputReport {
  std::string vehicle;
  std::vector<std::string> files;
  std::string lidar_topic, imu_topic;  ///< empty: none
  std::string lidar_frame, imu_frame;
  wire::CloudFormat cloud_format;
  bool has_imu = false;
  double accel_scale = 1.0;  ///< to m/s^2
  double gyro_scale = 1.0;   ///< to rad/s
  geometry::SE3 T_body_lidar;
  std::string T_body_lidar_origin;  ///< "settings", "/tf_static", "maker", "ground", "turning",
                                    ///< "assumed zero"
  geometry::SE3 T_body_imu;
  std::string T_body_imu_origin;       ///< empty: settings; else the frames, or why body = IMU
  std::string lidar_stamp = "header";  ///< or "record"
  std::string imu_stamp = "header";
  LidarTimeOffset lidar_time_offset;
  imu::MountingByTurning mounting;
  bool mounting_in_question = false;  ///< T_body_lidar is assumed, or does not fit the ground
  ClockOffset clock_offset;
  Time t_start, t_end;  ///< of the events passed on
  std::uint64_t scans = 0;
  std::uint64_t imu_samples = 0;
  std::uint64_t ranges = 0;
  std::optional<RangeLatency> range_latency;            ///< estimated from the vehicle's own motion
  std::map<std::string, std::uint64_t> range_messages;  ///< per topic that a source names
  InputGaps gaps;
  FindingList findings;
};

}  // namespace rali::drive
