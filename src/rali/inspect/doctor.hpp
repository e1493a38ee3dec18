#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/imu/rotation_study.hpp"
#include "rali/wire/cloud_format.hpp"

namespace rali::inspect {

/// What the doctor looks at. Empty texts: found by itself.
struct DoctorOptions {
  std::string path;  ///< recording, or folder of scans
  std::string vehicle = "v1";
  double seconds = 120.0;  ///< from the start of the recording; 0: all of it
  std::string lidar_topic, imu_topic;
  wire::CloudFormatOptions cloud;
  std::optional<geometry::SE3> T_body_lidar;  ///< empty: /tf_static if it is there
  geometry::SE3 T_body_imu;
  std::string ranges_file;        ///< ranges.csv; empty: topics of the recording only
  std::string out_dir = ".";      ///< whose disk D20 asks about
  double disk_free_bytes = -1.0;  ///< for tests; negative: ask the disk
};

/// Everything the doctor found out; findings worst first.
struct DoctorReport {
  std::string path, vehicle;
  double seconds = 0.0;  ///< of data looked at
  std::string lidar_topic, imu_topic;
  std::string lidar_frame, imu_frame;
  std::optional<wire::CloudFormat> format;
  double accel_scale = 1.0, gyro_scale = 1.0;
  imu::RotationStudy rotations;
  std::optional<geometry::SE3> T_body_lidar;  ///< as given or by /tf_static
  FindingList findings;

  /// True if an error spoils the map (exit code 1).
  [[nodiscard]] bool has_error() const;
};

/// Examines one recording: reads the first `seconds` as a stream, runs LiDAR odometry over them
/// and compares its turning with the gyro's.
/// Errors: kInput if the file cannot be read at all (what it is, is said).
[[nodiscard]] Result<DoctorReport> examine(const DoctorOptions& options, Executor& executor);

/// Severity as the user reads it: "error", "warning", "info".
[[nodiscard]] const char* severity_name(Severity severity);

/// The report for a terminal.
[[nodiscard]] std::string doctor_text(const DoctorReport& report);
/// doctor.json, schema 1.
[[nodiscard]] std::string doctor_json(const DoctorReport& report);
/// A first fleet.yaml with everything that was found.
[[nodiscard]] std::string doctor_fleet_yaml(const std::vector<DoctorReport>& reports);

}  // namespace rali::inspect
