#pragma once

#include <vector>

#include "rali/eval/association.hpp"
#include "rali/eval/statistics.hpp"

namespace rali::eval {

/// Error of one pose or of one piece of way.
struct PoseError {
  Time t;
  double translation_m = 0.0;
  double rotation_rad = 0.0;  ///< angle, 0..pi
};

/// Absolute pose error as evo has it: E_i = T_ref_i^-1 (T_ref_est T_est_i).
[[nodiscard]] std::vector<PoseError> absolute_errors(const PairList& pairs,
                                                     const geometry::SE3& T_ref_est);

struct RelativeOptions {
  double distance_m = 10.0;  ///< along the way
  /// true: a piece begins at each pose (evo --all_pairs). false: each begins where the one before
  /// ended, the first at distance_m (evo without --all_pairs).
  bool all_pairs = true;
  double tolerance = 0.1;  ///< all_pairs: pieces whose length is off by a larger share do not count
  /// false: lengths are those of the reference (evo --pairs_from_reference), true: of the estimate.
  bool along_estimate = false;
};

/// Relative pose error as evo has it: E = (Q_i^-1 Q_j)^-1 (P_i^-1 P_j) with Q the reference, P the
/// estimate, j the pose whose way from i is nearest to distance_m. Needs no alignment. Empty if
/// the way is too short.
[[nodiscard]] std::vector<PoseError> relative_errors(const PairList& pairs,
                                                     const RelativeOptions& options);

/// Signed error of the position along one axis of the reference frame, after alignment [m].
[[nodiscard]] std::vector<double> axis_errors(const PairList& pairs, const geometry::SE3& T_ref_est,
                                              const geometry::Vec3& axis_ref);

/// Signed error of the position along the reference's direction of travel over the last
/// `chord_m` metres [m]: how far the estimate slips in a corridor. Poses before the first
/// chord_m metres give 0.
[[nodiscard]] std::vector<double> along_way_errors(const PairList& pairs,
                                                   const geometry::SE3& T_ref_est, double chord_m);

[[nodiscard]] Statistics translation_statistics(const std::vector<PoseError>& errors);
[[nodiscard]] Statistics rotation_statistics(const std::vector<PoseError>& errors);  ///< rad

/// Way along the reference [m].
[[nodiscard]] double way_length_m(const PairList& pairs);

}  // namespace rali::eval
