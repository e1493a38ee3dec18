#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "rali/base/time.hpp"
#include "rali/geometry/types.hpp"
#include "rali/report/degenerate_data.hpp"
#include "rali/report/numbers.hpp"
#include "rali/report/range_data.hpp"

namespace rali::report {

/// All times are seconds since the start of the run, all positions are in the frame `map`, unless
/// the name says otherwise.

/// Root of the expected squared 3-D position error.
struct SigmaPoint {
  double t_s = 0.0;
  double sigma_m = kUnknown;
  std::array<float, 6> cov_m2{};  ///< xx xy xz yy yz zz, axes of the map

  /// Expected error along a unit vector of the map.
  [[nodiscard]] double along_m(const geometry::Vec3& axis) const;
};

struct ErrorPoint {
  double t_s = 0.0;
  double ape_m = kUnknown, rot_deg = kUnknown;
  geometry::Vec3 e_m = geometry::Vec3::Constant(kUnknown);
  double along_degenerate_m = kUnknown;
  double nees = kUnknown;
};

/// One vehicle's entry of metrics.json.
struct VehicleNumbers {
  Number path_m, scans, scans_dropped, keyframes, degenerate_fraction, degenerate_held_fraction,
      sigma_median_m, sigma_max_m, diverged_s, time_offset_s, clock_offset_s, accel_scale,
      accel_noise, accel_noise_stated, gyro_noise,
      gyro_noise_stated;  ///< noise: m/s2/rtHz, rad/s/rtHz
  NamedNumbers gaps;
};

struct VehicleView {
  std::string name;
  VehicleNumbers numbers;
  std::vector<PathPoint> path;
  std::vector<PathPoint> odometry;  ///< in its own odom frame
  std::vector<SigmaPoint> sigmas;
  std::vector<DegeneracyPoint> degeneracy;
  std::vector<DegenerateSpan> degenerate;
  DegeneratePath degenerate_path;
  std::vector<Received> received;  ///< ranges to or from it, by time
  std::vector<ErrorPoint> errors;
  std::vector<PathPoint> truth;  ///< transformed to map
  bool in_map = true;            ///< false: its frame differs from that of map.*
};

struct RangePair {
  std::string name;
  Number bias_m, bias_sigma_m, residual_std_m, latency_s, latency_sigma_s;
};

struct RangeNumbers {
  Number total, used;
  NamedNumbers rejected;
  std::vector<RangePair> pairs;
};

/// How a vehicle is connected to the fleet's frame: an entry of `fleet.frames` in metrics.json.
struct FleetFrame {
  std::string vehicle, decided_by, waits_for;
  Number sigma_m, sigma_rad;
};

struct Round {
  std::string round, anchor, ended_by, next_anchor;
  double start_s = kUnknown, end_s = kUnknown;
};

/// A frontier: the border of the observed space.
struct Frontier {
  std::string round, id, nearest_vehicle, state, reason;
  geometry::Vec3 p_m = geometry::Vec3::Constant(kUnknown);  ///< z unknown
  double length_m = kUnknown;
};

struct Loop {
  std::string vehicle_from, vehicle_to, reason;
  double from_s = kUnknown, to_s = kUnknown, score = kUnknown, shift_m = kUnknown;
  bool accepted = false;
};

/// Points of map.pcd, column by column.
struct MapPoints {
  std::vector<float> x_m, y_m, z_m, sigma_m;
  std::vector<std::uint8_t> vehicle;

  [[nodiscard]] std::size_t size() const { return x_m.size(); }
};

/// Number of keyframes that could contradict the map, and of contradictions found.
struct SelfCheck {
  Number keyframes, checked, contradictions;
};

struct Warning {
  std::string id, vehicle, text;
};

struct Timing {
  Number total_s, data_s, speed, memory_max_mb;
  NamedNumbers stages_s;
};

struct SettingLine {
  std::string key, value, origin;
};

/// One scalar of evaluation.json; `key` is the path with dots.
struct Measured {
  std::string key;
  std::string text;         ///< as written there
  double value = kUnknown;  ///< if it is a number
};

/// Axes of a frame of the run, expressed in those of the ground truth.
struct TruthFrame {
  std::vector<std::string> vehicles;
  geometry::Mat3 R_truth_map = geometry::Mat3::Identity();
};

/// Everything the report of one run shows, read from its folder.
struct RunData {
  std::string name;    ///< last part of the folder's path
  std::string status;  ///< of status.json; "" if there is none
  std::string version;
  Time begin;  ///< first stamp of the data; 0: unknown
  Number duration_s;
  std::vector<VehicleView> vehicles;
  std::vector<std::vector<std::string>> groups;  ///< vehicles that share one frame
  std::vector<FleetFrame> frames;
  Number loops_accepted, loops_refused, rounds_count;
  RangeNumbers ranges;
  RangeTable range_table;  ///< of ranges.csv
  std::vector<Round> rounds;
  std::vector<Loop> loops;
  std::vector<Frontier> frontiers;
  Number map_points, map_voxel_m, map_thickness_m;
  MapPoints map;                      ///< thinned, see read_thinned_map
  std::uint64_t map_file_points = 0;  ///< before thinning
  SelfCheck self_check;
  std::vector<Warning> warnings;
  Timing timing;
  bool settings_known = false;
  std::vector<SettingLine> settings;  ///< not default
  std::vector<Measured> evaluation;   ///< empty: not evaluated
  std::vector<TruthFrame> truth_frames;
  bool metrics_known = false;
  std::vector<std::string> unreadable;  ///< existing but unreadable files, with the reason

  [[nodiscard]] bool evaluated() const { return !evaluation.empty(); }
};

}  // namespace rali::report
