#pragma once

#include <limits>
#include <string>

#include "run.hpp"

namespace rali::tunnel {

inline constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Errors of one path. Along the axis: along the true direction of travel over a metre.
struct PathScores {
  double axial_rmse_m = kNone, axial_max_m = kNone;  ///< after the best alignment (SE(3))
  double lateral_rmse_m = kNone, vertical_rmse_m = kNone;
  double ape_rmse_m = kNone, ape_max_m = kNone;
  double start_rmse_m = kNone, start_max_m = kNone;  ///< along the axis, first poses aligned
  double nees_axial = kNone, nees6 = kNone;  ///< means at 1 Hz, poses laid together after 1 s
};

/// Figures of one run. NaN where there is nothing to measure.
struct Scores {
  std::string row, scene;
  std::uint64_t seed = 0;
  bool ranges = true;
  PathScores live, smoothed;
  double way_m = 0.0;
  double judged_s = 0.0;   ///< length of what was judged
  double t_worst_s = 0.0;  ///< of the largest live error along the axis, aligned
  double heard = kNone;    ///< share of the seconds in which a range came
  double nis = kNone;      ///< mean normalised innovation squared of used ranges
  double blind = kNone;    ///< share of poses
  double used = kNone;     ///< share of ranges
  double bad = kNone;      ///< share of ranges more than 0.3 m off
  double bad_refused = kNone, good_kept = kNone;
  double loss_growth_m = kNone;  ///< of the error along the axis by a radio loss
  double loss_back_s = kNone;    ///< until it is below 0.2 m again; infinite: never
  double cpu_ms = kNone, cpu_p99_ms = kNone;
  double cloud_mean_m = kNone, cloud_sd_m = kNone, cloud_beyond = kNone;
  std::size_t poses = 0, sweeps = 0, diverged = 0, findings = 0;
};

/// Errors (kNoAnswer): no poses.
[[nodiscard]] Result<Scores> score(const Track& track, const Recording& recording, const Row& row);

/// One line per sweep and per range, as CSV: where and in which direction it goes wrong.
void dump(const std::string& dir, const Track& track, const Row& row, std::uint64_t seed);

}  // namespace rali::tunnel
