#pragma once

#include <optional>
#include <vector>

#include "rali/eval/association.hpp"
#include "rali/eval/errors.hpp"

namespace rali::eval {

/// How far the end is off when the first poses are laid onto each other.
struct Drift {
  double final_m = 0.0;       ///< distance of the last positions
  double final_rad = 0.0;     ///< angle between the last attitudes
  double way_m = 0.0;         ///< along the reference
  std::optional<double> z_m;  ///< height gained by the estimate less that of the reference
};

/// Needs no alignment: each gains its height in its own frame. z_m is nothing if `T_ref_est` says
/// that the two frames do not share their vertical (more than 10 degrees apart).
/// @param pairs at least one
[[nodiscard]] Drift drift(const PairList& pairs, const geometry::SE3& T_ref_est);

/// Error of the position while one direction was blind.
struct BlindError {
  std::size_t pair = 0;   ///< index in the list of pairs
  double along_m = 0.0;   ///< signed, along the blind direction
  double across_m = 0.0;  ///< distance from the line through the true position along it
};

/// @param directions  per estimate (by PosePair::est_index), unit, in the estimate's frame; zero
///        where it was not blind
[[nodiscard]] std::vector<BlindError> blind_errors(const PairList& pairs,
                                                   const geometry::SE3& T_ref_est,
                                                   const std::vector<geometry::Vec3>& directions);

/// Whether the error looks like one of time: position error = speed times shift, beside another
/// place of the whole way, which an alignment takes for a part of it.
struct TimeShift {
  double shift_s = 0.0;       ///< to be added to the estimate's stamps
  double rmse_m = 0.0;        ///< of the positions, the way laid where it fits best
  double rmse_after_m = 0.0;  ///< if the stamps were so shifted
};

/// Least squares of the position errors on the reference's velocity. Nothing without motion.
[[nodiscard]] std::optional<TimeShift> time_shift(const PairList& pairs,
                                                  const geometry::SE3& T_ref_est);

/// Relative pose error between two vehicles at equal times, no alignment at all:
/// E = (Q_a^-1 Q_b)^-1 (P_a^-1 P_b). At each pose of a, b's estimate is taken from the two poses
/// around it, at most max_gap_s apart.
/// @param a, b  pairs in rising time
[[nodiscard]] std::vector<PoseError> errors_between(const PairList& a, const PairList& b,
                                                    double max_gap_s);

}  // namespace rali::eval
