#pragma once

#include <string>
#include <vector>

#include "rali/eval/association.hpp"
#include "rali/sim/simulation.hpp"
#include "rali/vehicle/event.hpp"

namespace rali::accuracy {

/// One scan as processed by the vehicle.
struct ScanRow {
  vehicle::PoseEstimate pose;
  eval::StampedPose truth;
  double cpu_ms = 0.0;  ///< of all steps since the last scan
};

/// Figures of one run. Trajectory errors after SE(3) alignment unless stated otherwise.
struct Scores {
  std::string scene, preset;
  std::uint64_t seed = 0;
  double path_m = 0.0;
  std::size_t scans = 0, poses = 0;
  double ape_rmse_m = 0.0, ape_max_m = 0.0, z_rmse_m = 0.0;
  double end_m = 0.0;    ///< error of the last pose, first poses aligned
  double rpe10_m = 0.0;  ///< rmse over 10 m, all pairs
  double rpe10_deg = 0.0;
  double slip_rmse_m = 0.0;         ///< along the path
  double nees6 = 0.0, nees3 = 0.0;  ///< mean over the run, first poses aligned
  double fraction95 = 0.0;          ///< of poses inside their 95 % ellipsoid
  double cpu_ms = 0.0, cpu_p99_ms = 0.0;
  double peak_mb = 0.0;
  std::size_t weak = 0, diverged = 0, findings = 0;
};

struct RunOptions {
  std::string preset, cache_dir, dump_dir;
  std::vector<std::string> settings;
};

/// Runs one recording through the vehicle and scores it. Errors: bad settings, no pose at all.
[[nodiscard]] Result<Scores> run(const sim::SimOptions& sim, const RunOptions& options);

}  // namespace rali::accuracy
