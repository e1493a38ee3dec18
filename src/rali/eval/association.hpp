#pragma once

#include <cstddef>
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
  kNearest,     ///< the reference pose nearest in time (evo)
  kInterpolate  ///< between the reference poses before and after
};

struct AssociationOptions {
  AssociationMode mode = AssociationMode::kNearest;
  double max_dt_s = 0.01;   ///< kNearest: farther reference poses do not count
  double max_gap_s = 0.25;  ///< kInterpolate: no interpolation across a longer gap
};

struct Association {
  PairList pairs;
  std::size_t unmatched = 0;  ///< estimates without a reference
};

/// Pairs each estimate with the reference. Errors: a list that is not in strictly rising time
/// (kInput), no pair at all (kNoAnswer).
[[nodiscard]] Result<Association> associate(const PoseList& est, const PoseList& ref,
                                            const AssociationOptions& options);

}  // namespace rali::eval
