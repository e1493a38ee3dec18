#pragma once

#include <vector>

#include "rali/eval/association.hpp"
#include "rali/eval/statistics.hpp"

namespace rali::eval {

/// Error of one pose or of one piece of a trajectory.
struct PoseError {
  Time t;
  double translation_m = 0.0;
  double rotation_rad = 0.0;  ///< angle, 0..pi
};

/// Absolute pose error as defined by evo: E_i = T_ref_i^-1 (T_ref_est T_est_i).
[[nodiscard]] std::vector<PoseError> absolute_errors(const PairList& pairs,
                                                     const geometry::SE3& T_ref_est);

struct RelativeOptions {
  double distance_m = 10.0;  ///< along the path
  /// true: a piece starts at each pose (evo --all_pairs). false: each starts at the end of the one
  /// before, the first at distance_m (evo without --all_pairs).
  bool all_pairs = true;
  double tolerance = 0.1;  ///< all_pairs: largest relative length error of a piece
  /// false: lengths are those of the reference (evo --pairs_from_reference), true: of the estimate.
  bool along_estimate = false;
};

/// Relative pose error as defined by evo: E = (Q_i^-1 Q_j)^-1 (P_i^-1 P_j) with Q the reference, P
/// the estimate, j the pose whose distance along the path from i is nearest to distance_m. Needs no
/// alignment. Empty if the path is too short.
[[nodiscard]] std::vector<PoseError> relative_errors(const PairList& pairs,
                                                     const RelativeOptions& options);

/// Signed error of the position along one axis of the reference frame, after alignment [m].
[[nodiscard]] std::vector<double> axis_errors(const PairList& pairs, const geometry::SE3& T_ref_est,
                                              const geometry::Vec3& axis_ref);

/// Signed position error along the reference's direction of travel over the last `chord_m` metres
/// [m]: the longitudinal slip of the estimate in a corridor. Poses in the first chord_m metres give
/// 0.
[[nodiscard]] std::vector<double> along_path_errors(const PairList& pairs,
                                                    const geometry::SE3& T_ref_est, double chord_m);

[[nodiscard]] Statistics translation_statistics(const std::vector<PoseError>& errors);
[[nodiscard]] Statistics rotation_statistics(const std::vector<PoseError>& errors);  ///< rad

/// Length of the reference path [m].
[[nodiscard]] double path_length_m(const PairList& pairs);

}  // namespace rali::eval
