#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/base/time.hpp"
#include "rali/geometry/se3.hpp"

namespace rali::eval {

/// A pose with its time. The frames are the caller's; all poses of one trajectory share them.
struct StampedPose {
  Time t;
  geometry::SE3 T;
};

using PoseList = std::vector<StampedPose>;

/// Estimate and reference at the same time.
struct PosePair {
  Time t;  ///< of the estimate
  geometry::SE3 est, ref;
  std::size_t est_index = 0;  ///< in the list of estimates
};

using PairList = std::vector<PosePair>;

enum class AssociationMode {
  kNearest,     ///< the pose nearest in time, as evo: from the list with fewer poses to the other
  kInterpolate  ///< the reference, interpolated between the poses before and after
};

struct AssociationOptions {
  AssociationMode mode = AssociationMode::kNearest;
  double max_dt_s = 0.01;  ///< kNearest: poses farther apart are not paired
  double max_gap_s = 0.2;  ///< kInterpolate: no interpolation across a longer gap
};

struct Association {
  PairList pairs;             ///< in rising time
  std::size_t unmatched = 0;  ///< poses of the first list (see kNearest) without a partner
};

/// Pairs estimate and reference by time. Errors: a list whose times do not strictly increase
/// (kInput), no pair at all (kNoAnswer).
[[nodiscard]] Result<Association> associate(const PoseList& est, const PoseList& ref,
                                            const AssociationOptions& options);

/// The interpolated pose at time t in a list of increasing time: rotation at constant rate,
/// position linear. Empty before the first pose, after the last, or across a gap longer than
/// max_gap_s.
[[nodiscard]] std::optional<geometry::SE3> pose_at(const PoseList& list, Time t, double max_gap_s);

}  // namespace rali::eval
