#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "rali/scenario/scene/scene_setup.hpp"
#include "ranges.hpp"

namespace rali::campaign {

/// A time interval, in seconds since the start of the simulation.
struct Span {
  double start_s = 0.0, end_s = 0.0;

  [[nodiscard]] bool contains(double t_s) const { return t_s >= start_s && t_s < end_s; }
};

/// Faults of the ranges of a whole fleet, besides the radio model's own errors.
struct RangeFaults {
  double stamp_shift_s = 0.0;  ///< added to the stamps: positive is late
  std::vector<Span> missing;
  std::vector<Span> frozen;  ///< every pair repeats its value at the start of the span
  std::vector<Span> biased;
  double biased_m = 0.0;
  std::vector<Span> obstructed;  ///< an exponentially distributed excess is added
  double obstructed_m = 0.0;     ///< its mean
};

/// A start pose as given by the user.
struct GivenPrior {
  int vehicle = 0, relative_to = 0;
  geometry::Vec3 error_m = geometry::Vec3::Zero();  ///< against ground truth
  double error_deg = 0.0;
  double sigma_m = 0.2, sigma_deg = 3.0;
};

/// Noise densities as given by the user.
struct ClaimedNoise {
  double accel_mps2_rthz = 0.0, gyro_radps_rthz = 0.0;
};

/// One recording of the campaign: the simulation and the user's configuration for it.
struct Case {
  std::uint64_t seed = 0;
  scenario::SceneSetup setup;
  std::string scene;  ///< name in ranges.yaml
  std::string plan;   ///< of a fleet; empty: one vehicle
  double duration_s = 60.0;
  bool in_motion = false, in_turn = false;  ///< state of motion at the start of the recording
  double stop_s = 0.0;                      ///< total time of stops on the path
  std::optional<ClaimedNoise> noise;
  double time_offset_s = 0.0;  ///< added to the stamps of the inertial sensor
  std::vector<Span> lidar_missing, lidar_covered, imu_missing;
  RangeFaults ranges;
  std::string prior_kind;  ///< good, wrong, none
  std::vector<GivenPrior> priors;
  std::set<std::string> features;  ///< features of the case, for the table

  [[nodiscard]] bool has_imu() const { return setup.fleet.vehicle.with_imu; }
};

/// A case is fully determined by its seed and the ranges.
[[nodiscard]] Case draw_case(const Ranges& ranges, std::uint64_t seed);

}  // namespace rali::campaign
