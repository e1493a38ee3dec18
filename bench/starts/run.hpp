#pragma once

#include <string>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/vehicle/settings.hpp"
#include "recording.hpp"

namespace rali::bench {

/// One pose of a run against the reference, both relative to the first pose.
struct StartPose {
  double t_s = 0.0;  ///< since the first scan of the run
  double error_m = 0.0;
  double error_deg = 0.0;
  double sigma_m = 0.0;  ///< stated, worst direction
  bool cut = false;      ///< reported as lost
  int matches = 0;
};

/// Result of a recording that starts somewhere in the middle.
struct StartRun {
  std::vector<StartPose> poses;
  FindingList findings;  ///< warnings and errors
  bool lost = false;     ///< reported as lost at least once
  double error_max_m = 0.0;
  double silent_max_m = 0.0;  ///< largest unreported error
  double path_m = 0.0;        ///< of the reference
};

struct StartOptions {
  double start_s = 0.0;
  double duration_s = 0.0;  ///< 0: to the end
};

/// Runs the scans of that interval through a vehicle without inertial data. An error beyond
/// `limit_m` is unreported unless a loss was reported before and the error is below 3.5 stated
/// sigmas.
[[nodiscard]] StartRun run_start(const ReferencedScans& scans, const StartOptions& options,
                                 const vehicle::VehicleSettings& settings, double limit_m);

}  // namespace rali::bench
