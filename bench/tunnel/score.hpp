#pragma once

#include <limits>
#include <string>

#include "run.hpp"

namespace rali::tunnel {

inline constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Errors of one trajectory. Axial: along the true direction of travel over a metre.
struct PathScores {
  double axial_rmse_m = kNone, axial_max_m = kNone;  ///< after the best alignment (SE(3))
  double lateral_rmse_m = kNone, vertical_rmse_m = kNone;
  double ape_rmse_m = kNone, ape_max_m = kNone;
  double start_rmse_m = kNone, start_max_m = kNone;  ///< axial, first poses aligned
  double nees_axial = kNone, nees6 = kNone;          ///< means at 1 Hz, poses aligned after 1 s
};

/// Figures of one run. NaN where nothing can be measured.
struct Scores {
  std::string row, scene;
  std::uint64_t seed = 0;
  bool ranges = true;
  PathScores live, smoothed;
  double path_m = 0.0;
  double judged_s = 0.0;      ///< duration of the scored part
  double t_worst_s = 0.0;     ///< time of the largest live axial error, aligned
  double received = kNone;    ///< fraction of the seconds with a range
  double nis = kNone;         ///< mean normalised innovation squared of used ranges
  double degenerate = kNone;  ///< fraction of poses
  double used = kNone;        ///< fraction of ranges
  double bad = kNone;         ///< fraction of ranges with an error above 0.3 m
  double bad_refused = kNone, good_kept = kNone;
  double loss_growth_m = kNone;  ///< growth of the axial error during a radio loss
  double loss_back_s = kNone;    ///< time until it is below 0.2 m again; infinite: never
  double cpu_ms = kNone, cpu_p99_ms = kNone;
  double cloud_mean_m = kNone, cloud_sd_m = kNone, cloud_beyond = kNone;
  std::size_t poses = 0, scans = 0, diverged = 0, findings = 0;
};

/// Errors (kNoAnswer): no poses.
[[nodiscard]] Result<Scores> score(const Track& track, const Recording& recording, const Row& row);

/// Writes one line per scan and per range as CSV: position and direction of the errors.
void dump(const std::string& dir, const Track& track, const Row& row, std::uint64_t seed);

}  // namespace rali::tunnel
