#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rali/drive/map_run.hpp"
#include "recording.hpp"
#include "solvable.hpp"

namespace rali::campaign {

/// An interval of one trajectory whose error is far above its stated sigma, without a finding.
struct SilentFailure {
  std::string vehicle;
  std::string trajectory;             ///< odometry, live or final
  double start_s = 0.0, end_s = 0.0;  ///< since the start of the recording
  double error_m = 0.0;               ///< largest
  double sigma_m = 0.0;               ///< largest stated sigma of the trajectory's position
};

/// Errors of one trajectory of a vehicle against ground truth.
struct TrackScore {
  double rmse_m = 0.0, max_m = 0.0, end_m = 0.0;
  double sigma_max_m = 0.0;    ///< largest stated
  double nees_position = 0.0;  ///< per degree of freedom, poses 5 s apart
  std::size_t poses = 0;
  std::vector<std::pair<double, double>> failures_s;  ///< error above the bound for too long
};

struct VehicleScore {
  std::string name;
  std::optional<TrackScore> odometry, live, final;
  double distance_m = 0.0;
  double diverged_s = 0.0;
  int pose_findings = 0;  ///< findings that the pose is or may be lost
};

/// All results of one run.
struct RunScore {
  Solvable solvable;
  std::vector<VehicleScore> vehicles;
  std::vector<SilentFailure> silent;
  /// Failures for which only odometry.degenerate was reported. Their sigma is too small, or the
  /// alignment of the whole path moved the error to another place.
  std::size_t only_degenerate = 0;
  std::size_t groups = 1;
  double fleet_rmse_m = 0.0;  ///< final, one alignment for the largest group
  bool gaps = false;          ///< exit code 3
  bool lost = false;          ///< a vehicle was lost by the run's own report
  std::size_t ranges = 0, ranges_used = 0;
  std::vector<std::string> reported;  ///< ids of findings that are warnings or errors, each once
  std::string error;                  ///< the run failed with this sentence
};

/// @param out_dir  of the run
[[nodiscard]] RunScore judge_run(const Recording& recording, const drive::MapSummary& summary);

}  // namespace rali::campaign
