#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"
#include "rali/drive/offset/lidar_turning.hpp"
#include "rali/drive/ranges/range_options.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/imu/rotation_study.hpp"
#include "rali/inspect/range_study.hpp"
#include "rali/wire/cloud_format.hpp"

namespace rali::inspect {

/// A topic with ranges, and the radio number of each vehicle.
struct RangeTopicNames {
  std::string topic;
  std::map<std::int64_t, std::string> names;
};

/// Inputs of the doctor. Empty strings: detected automatically.
struct DoctorOptions {
  std::string path;  ///< recording, or folder of scans
  std::string vehicle = "v1";
  double seconds = 120.0;  ///< from the start of the recording; 0: all of it
  std::string lidar_topic, imu_topic;
  wire::CloudFormatOptions cloud;
  std::optional<geometry::SE3> T_body_lidar;  ///< empty: /tf_static if it is there
  geometry::SE3 T_body_imu;
  std::string imu_file;  ///< CSV next to a folder of scans; empty: imu.csv of the folder
  /// Topics of ranges to use; empty: all, with radios by their number.
  std::optional<std::vector<RangeTopicNames>> range_topics;
  std::string out_dir = ".";      ///< D20 checks the free space of its disk
  double disk_free_bytes = -1.0;  ///< for tests; negative: ask the disk
};

/// All results for one recording; worst findings first.
struct DoctorReport {
  std::string path, vehicle;
  double seconds = 0.0;  ///< of data examined
  std::string lidar_topic, imu_topic;
  std::string lidar_frame, imu_frame;
  std::optional<wire::CloudFormat> format;
  double accel_scale = 1.0, gyro_scale = 1.0;
  imu::RotationStudy rotations;
  std::optional<geometry::SE3> T_body_lidar;  ///< as given or from /tf_static
  Time t_start, t_end;                        ///< stamps of the clouds; equal: end unknown
  std::vector<ranging::TrackPoint> track;     ///< of the LiDAR, by LiDAR odometry alone
  FindingList findings;
};

/// All recordings of all vehicles, and the ranges between them.
struct DoctorResult {
  std::vector<DoctorReport> recordings;
  FindingList ranges;
};

/// True if an error would spoil the map (exit code 1).
[[nodiscard]] bool has_error(const FindingList& findings);

/// Examines one recording: reads the first `seconds` as a stream, runs LiDAR odometry over them and
/// compares its rotation with the gyro's. Its ranges are added to those of the fleet. Errors:
/// kInput, with its kind, if the file cannot be read at all.
[[nodiscard]] Result<DoctorReport> examine(const DoctorOptions& options, Executor& executor,
                                           RangeStudy& ranges);

/// Sources of the ranges of a fleet, and its vehicles.
struct RangeInputs {
  std::vector<std::string> files;     ///< CSV
  std::vector<std::string> topics;    ///< of the recordings
  std::vector<std::string> vehicles;  ///< names of the fleet; empty: unknown
  /// Logs of serial ports, their vehicles by number in `vehicles`, and how to read them.
  drive::RangeOptions serial;
  bool separate = false;  ///< clock: separate, recorded on different days
};

/// D14 to D16 of all ranges: those of the recordings and of the CSV files; a topic missing in all
/// recordings (`ranges.no_topic`, as in rali map). D17 of the recordings.
/// Errors: kInput (no file, a column missing, no row of numbers).
[[nodiscard]] Result<FindingList> examine_ranges(const RangeInputs& inputs,
                                                 const std::vector<DoctorReport>& recordings,
                                                 RangeStudy& ranges);

/// Severity as the user reads it: "error", "warning", "info".
[[nodiscard]] const char* severity_name(Severity severity);

/// The reports for a terminal.
[[nodiscard]] std::string doctor_text(const DoctorReport& report);
[[nodiscard]] std::string ranges_text(const FindingList& findings);
/// doctor.json, schema 2: one document for any number of recordings.
[[nodiscard]] std::string doctor_json(const DoctorResult& result);
/// An initial fleet.yaml with all results; several recordings of a vehicle are a list. It includes
/// ranges and antennas of several vehicles, with values to be measured as comments.
[[nodiscard]] std::string doctor_fleet_yaml(const std::vector<DoctorReport>& reports,
                                            const RangeInputs& inputs = {},
                                            const RangeStudy& ranges = {});

}  // namespace rali::inspect
