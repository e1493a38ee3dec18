#pragma once

#include <optional>

#include "rali/eval/association.hpp"

namespace rali::eval {

/// The gauge of a map: the freedom that no measurement constrains, fixed by one pose, the
/// reference. In map the reference is exact by definition, so a covariance of T_map_body is
/// relative to the reference. An error must be relative to it, too:
///
///   T_map_truth = T_map_ref W_ref^-1,   e_i = boxminus(T_map_truth W_i, T_map_i)
///
/// W: ground truth in its own frame. A best fit over all poses would absorb a part of the error
/// that the covariance covers. e of the reference is always zero, so the reference has no NEES.
struct Gauge {
  geometry::SE3 T_est_ref;            ///< maps the ground truth to the frame of the estimate
  std::optional<PosePair> reference;  ///< empty: the estimate is in the ground truth's own frame

  /// True for the reference itself and for poses with no motion since, in estimate and ground
  /// truth.
  [[nodiscard]] bool holds(const PosePair& pair) const;
};

/// The gauge fixed by one pose.
[[nodiscard]] Gauge gauge_of(const PosePair& reference);

/// The gauge with origin and heading of one pose and the level of another: a vehicle that has stood
/// since its start knows its level to a degree only, and the map has that of one that drove.
[[nodiscard]] Gauge gauge_of(const PosePair& reference, const PosePair& level);

}  // namespace rali::eval
