#pragma once

#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "slam_run.hpp"

namespace rali::ranges_bench {

/// One problem solved in three ways: odometry alone, batch, incremental.
struct SlamScores {
  std::string name;
  std::size_t poses = 0, ranges = 0;
  double path_m = 0.0;
  std::size_t beacons = 0, certain = 0;
  double ape_odometry_m = 0.0, ape_batch_m = 0.0, ape_window_m = 0.0;
  /// The same graph started at ground truth. A cost different from `cost` means that the initial
  /// beacon positions led to a wrong minimum.
  double ape_from_truth_m = 0.0, cost_from_truth = 0.0;
  /// With sigmas as large as the errors; NaN where there are no errors.
  double ape_measured_m = std::numeric_limits<double>::quiet_NaN();
  double beacons_off_m = 0.0;  ///< largest, of the batch
  double range_rms_m = 0.0;    ///< of the ranges against ground truth
  double sigma_m = 0.0;        ///< as stated, root mean square
  double steps_nees = 0.0;     ///< of the odometry's steps, 1 if consistent
  Innovations innovations;
  double cost = 0.0;
};

/// RMSE of the positions after the best planar rotation and translation (plane) or SE(3).
[[nodiscard]] Result<double> ape_rmse_m(const SlamProblem& problem, const eval::PoseList& estimate);

[[nodiscard]] Result<SlamScores> run_problem(const SlamProblem& problem);

/// All problems of the folder range_slam. Errors: a missing or damaged file.
[[nodiscard]] Result<std::vector<SlamProblem>> read_problems(const std::filesystem::path& folder);

[[nodiscard]] std::string slam_table(const std::vector<SlamScores>& scores);

}  // namespace rali::ranges_bench
