#pragma once

#include <optional>

#include "rali/eval/association.hpp"

namespace rali::eval {

/// The gauge of a map: what no measurement can tell, held by one pose, the reference. In map the
/// reference is known without error by definition, so a covariance of T_map_body is that of the
/// pose relative to the reference, and an error must be relative to it, too:
///
///   T_map_truth = T_map_ref W_ref^-1,   e_i = boxminus(T_map_truth W_i, T_map_i)
///
/// W: truth in its own frame. A best fit over all poses would take a part of the error away that
/// the covariance rightly states. e of the reference is zero whatever it states: it has no NEES.
struct Gauge {
  geometry::SE3 T_est_ref;            ///< brings the truth into the frame of the estimate
  std::optional<PosePair> reference;  ///< nothing: the estimate lies in the truth's own frame

  /// The reference itself, and poses that have not left it: neither estimate nor truth have moved.
  [[nodiscard]] bool holds(const PosePair& pair) const;
};

/// The gauge that one pose fixes.
[[nodiscard]] Gauge gauge_of(const PosePair& reference);

}  // namespace rali::eval
