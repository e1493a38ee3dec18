#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "rali/eval/drift.hpp"
#include "rali/eval/errors.hpp"
#include "rali/eval/gauge.hpp"
#include "rali/eval/statistics.hpp"

namespace rali::assess {

/// Everything about one judged pose.
struct PoseRow {
  Time t;
  double ape_m = 0.0, rot_rad = 0.0;
  geometry::Vec3 error_m = geometry::Vec3::Zero();  ///< estimate less truth, axes of the truth
  std::optional<double> along_blind_m;              ///< only while blind
  double across_blind_m = 0.0;                      ///< only while blind
  std::optional<double> nees6, nees3;
};

/// The judged poses of one vehicle, or of several after one another.
struct Samples {
  std::vector<PoseRow> rows;
  std::vector<std::vector<eval::PoseError>> rpe;  ///< per distance asked for
  std::size_t covariances_unusable = 0;
  std::size_t reference_poses = 0;  ///< without NEES: they hold the gauge
  bool has_blind = false;           ///< it is known where it was blind
  double way_m = 0.0;               ///< along the truth
  double blind_way_m = 0.0;         ///< of it blind
  double covered_s = 0.0;           ///< time between judged poses, gaps left out
  double truth_s = 0.0;             ///< length of the truth

  void append(const Samples& other);
};

/// NEES along one run.
struct NeesScore {
  int dof = 6;
  std::size_t poses = 0;
  double mean = 0.0;  ///< expectation: dof
  double median = 0.0;
  double share_within_95 = 0.0;  ///< expectation: 0.95
};

struct RpeScore {
  double distance_m = 0.0;
  eval::Statistics translation_m, rotation_rad;  ///< count 0: the way is too short
};

struct BlindScore {
  eval::Statistics along_m, across_m;  ///< count 0: never blind
  double way_share = 0.0;              ///< of the way that was blind
};

/// One column of the table.
struct TrackScore {
  std::size_t poses = 0;
  double time_share = 0.0;  ///< of the truth's time
  double way_m = 0.0;
  eval::Statistics ape_m, rotation_rad;
  std::vector<RpeScore> rpe;
  std::optional<BlindScore> blind;        ///< nothing without degeneracy/<v>.csv
  std::optional<NeesScore> nees6, nees3;  ///< nothing without usable covariances
  std::size_t covariances_unusable = 0;
  std::size_t reference_poses = 0;     ///< without NEES: they hold the gauge
  std::optional<double> alone_rmse_m;  ///< APE with an alignment of its own
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
                                 const std::vector<geometry::Vec3>& blind_map,
                                 const eval::PoseList& truth, const SampleOptions& options);

}  // namespace rali::assess
