#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "rali/eval/drift.hpp"
#include "rali/eval/errors.hpp"
#include "rali/eval/gauge.hpp"
#include "rali/eval/statistics.hpp"

namespace rali::assess {

/// Errors of one evaluated pose.
struct PoseRow {
  Time t;
  double ape_m = 0.0, rot_rad = 0.0;
  geometry::Vec3 error_m = geometry::Vec3::Zero();  ///< estimate minus ground truth, in the
                                                    ///< latter's axes
  std::optional<double> along_degenerate_m;         ///< only while degenerate
  double across_degenerate_m = 0.0;                 ///< only while degenerate
  std::optional<double> nees6, nees3;
};

/// The evaluated poses of one vehicle, or of several appended.
struct Samples {
  std::vector<PoseRow> rows;
  std::vector<std::vector<eval::PoseError>> rpe;  ///< per requested distance
  std::size_t covariances_unusable = 0;
  std::size_t reference_poses = 0;  ///< without NEES: they fix the gauge
  bool has_degenerate = false;      ///< degenerate poses are known
  double path_m = 0.0;              ///< along the ground truth
  double degenerate_path_m = 0.0;   ///< degenerate part of it
  double covered_s = 0.0;           ///< time between evaluated poses, gaps left out
  double truth_s = 0.0;             ///< duration of the ground truth

  void append(const Samples& other);
};

/// NEES of one run.
struct NeesScore {
  int dof = 6;
  std::size_t poses = 0;
  double mean = 0.0;  ///< expectation: dof
  double median = 0.0;
  double fraction_within_95 = 0.0;  ///< expectation: 0.95
};

struct RpeScore {
  double distance_m = 0.0;
  eval::Statistics translation_m, rotation_rad;  ///< count 0: the trajectory is too short
};

struct DegenerateScore {
  eval::Statistics along_m, across_m;  ///< count 0: never degenerate
  double path_fraction = 0.0;          ///< degenerate fraction of the distance
};

/// One column of the table.
struct TrackScore {
  std::size_t poses = 0;
  double time_fraction = 0.0;  ///< of the ground truth's duration
  double path_m = 0.0;
  eval::Statistics ape_m, rotation_rad;
  std::vector<RpeScore> rpe;
  std::optional<DegenerateScore> degenerate;  ///< nothing without degeneracy/<v>.csv
  std::optional<NeesScore> nees6, nees3;      ///< nothing without usable covariances
  std::size_t covariances_unusable = 0;
  std::size_t reference_poses = 0;     ///< without NEES: they fix the gauge
  std::optional<double> alone_rmse_m;  ///< APE with its own alignment
  std::optional<eval::Drift> drift;    ///< of one vehicle
};

/// @param distances_m  of Samples::rpe
[[nodiscard]] TrackScore score_of(const Samples& samples, const std::vector<double>& distances_m);

/// Samples of one vehicle.
struct SampleOptions {
  std::vector<double> distances_m;
  bool all_pairs = true;
  geometry::SE3 T_truth_est;  ///< alignment
  eval::Gauge gauge;          ///< of the covariances
};

[[nodiscard]] Samples samples_of(const eval::PairList& pairs,
                                 const std::vector<geometry::Mat6>& covariances,
                                 const std::vector<geometry::Vec3>& degenerate_map,
                                 const eval::PoseList& truth, const SampleOptions& options);

}  // namespace rali::assess
