#pragma once

#include <optional>
#include <vector>

#include "rali/eval/association.hpp"
#include "rali/eval/errors.hpp"

namespace rali::eval {

/// Error at the end of the path when the first poses are aligned.
struct Drift {
  double final_m = 0.0;       ///< distance between the last positions
  double final_rad = 0.0;     ///< angle between the last attitudes
  double path_m = 0.0;        ///< along the reference
  std::optional<double> z_m;  ///< height gained by the estimate minus that of the reference
};

/// Needs no alignment: each height gain is measured in its own frame. z_m is empty if, by
/// `T_ref_est`, the vertical axes of the two frames differ by more than 10 degrees.
/// @param pairs at least one
[[nodiscard]] Drift drift(const PairList& pairs, const geometry::SE3& T_ref_est);

/// Position error while one direction was degenerate.
struct DegenerateError {
  std::size_t pair = 0;   ///< index in the list of pairs
  double along_m = 0.0;   ///< signed, along the degenerate direction
  double across_m = 0.0;  ///< distance from the line in that direction through the true position
};

/// @param directions  per estimate (by PosePair::est_index), unit, in the estimate's frame; zero
///        where none was degenerate
[[nodiscard]] std::vector<DegenerateError> degenerate_errors(
    const PairList& pairs, const geometry::SE3& T_ref_est,
    const std::vector<geometry::Vec3>& directions);

/// Fits a time offset to the position error: error = velocity times offset, plus a rigid
/// displacement of the whole trajectory. An alignment absorbs part of the offset as such a
/// displacement.
struct TimeShift {
  double shift_s = 0.0;       ///< to be added to the estimate's stamps
  double rmse_m = 0.0;        ///< of the positions, with the best displacement and no offset
  double rmse_after_m = 0.0;  ///< the same with the offset applied
};

/// Least squares of the position errors on the reference's velocity. Empty without motion, and
/// where a constant displacement explains the errors as well (velocities nearly constant).
[[nodiscard]] std::optional<TimeShift> time_shift(const PairList& pairs,
                                                  const geometry::SE3& T_ref_est);

/// Relative pose error between two vehicles at equal times, without alignment:
/// E = (Q_a^-1 Q_b)^-1 (P_a^-1 P_b). At each pose of a, b's poses are interpolated between the two
/// around it, at most max_gap_s apart.
/// @param a, b  pairs in increasing time
[[nodiscard]] std::vector<PoseError> errors_between(const PairList& a, const PairList& b,
                                                    double max_gap_s);

}  // namespace rali::eval
