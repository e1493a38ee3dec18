#pragma once

#include <vector>

#include "rali/drive/output/pose_files.hpp"
#include "rali/eval/alignment.hpp"

namespace rali::tunnel {

/// Poses of a run with ground truth.
struct Judged {
  eval::PairList pairs;
  std::vector<geometry::Vec3> ahead;        ///< true direction of travel, per pair, unit
  std::vector<geometry::Mat6> covariances;  ///< of geometry::boxplus, by PosePair::est_index
};

/// Errors of positions along and across the true direction of travel, per pair [m].
struct AxisErrors {
  std::vector<double> axial, lateral, vertical;
};

/// Poses up to t_end. Errors: of eval::associate().
[[nodiscard]] Result<Judged> judge(const std::vector<drive::PoseRecord>& poses,
                                   const eval::PoseList& truth, Time t_end);

[[nodiscard]] AxisErrors axis_errors(const Judged& judged, const geometry::SE3& T_ref_est);

/// The best alignment, or that of the first pose where the path leaves its roll unobservable.
[[nodiscard]] geometry::SE3 best_alignment(const Judged& judged);

/// Alignment of the first poses.
[[nodiscard]] geometry::SE3 start_alignment(const Judged& judged);

/// The first pose at least after_s after the first one.
[[nodiscard]] std::size_t pair_after(const eval::PairList& pairs, double after_s);

/// Stated sigma along the true direction of travel [m], per pair, with poses aligned at `anchor`.
[[nodiscard]] std::vector<double> axial_sigmas(const Judged& judged, std::size_t anchor);

}  // namespace rali::tunnel
