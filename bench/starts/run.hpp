#pragma once

#include <string>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/vehicle/settings.hpp"
#include "recording.hpp"

namespace rali::bench {

/// One pose of a run against the reference, both seen from the first pose.
struct StartPose {
  double t_s = 0.0;  ///< since the first scan of the run
  double error_m = 0.0;
  double error_deg = 0.0;
  double sigma_m = 0.0;  ///< stated, worst direction
  bool cut = false;      ///< said to be lost
  int matches = 0;
};

/// A recording that begins somewhere in the middle.
struct StartRun {
  std::vector<StartPose> poses;
  FindingList findings;  ///< warnings and errors
  bool lost = false;     ///< said to be lost somewhere
  double error_max_m = 0.0;
  double silent_max_m = 0.0;  ///< largest error that was not said
  double path_m = 0.0;        ///< of the reference
};

struct StartOptions {
  double start_s = 0.0;
  double duration_s = 0.0;  ///< 0: to the end
};

/// Drives the scans of that stretch through a vehicle without inertial data. A pose is silent
/// about its error if that is beyond `limit_m`, nothing was said to be lost until then, or the
/// error is beyond 3.5 of the sigmas stated after a loss.
[[nodiscard]] StartRun run_start(const ReferencedScans& scans, const StartOptions& options,
                                 const vehicle::VehicleSettings& settings, double limit_m);

}  // namespace rali::bench
