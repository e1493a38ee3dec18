#pragma once

#include "rali/graph/window.hpp"

namespace rali::graph {

/// A quadratic cost + b.d + d.H d/2.
struct Quadratic {
  Eigen::MatrixXd H;
  Eigen::VectorXd b;
  double cost = 0.0;
};

/// Minimises over the first m unknowns and leaves a quadratic of the others: H = Hrr - Hrm Hmm^-1
/// Hmr, b = br - Hrm Hmm^-1 bm (algorithms 6.3, T12 b). Directions of Hmm with less than 1e-9 of
/// the information of the strongest (each unknown scaled to its own information) are dropped.
[[nodiscard]] Quadratic eliminate_first(const Quadratic& in, int m);

/// Takes noise out of a quadratic that should be positive semidefinite: directions below 1e-9 as
/// above lose both information and pull.
void drop_rounding(Quadratic& quadratic);

/// Puts all that touches the oldest keyframe into the dense prior and removes the keyframe, and
/// with it each retired landmark, bias or tau that no remaining range uses. The prior is linearised
/// at the present values. The window must have two keyframes or more.
void marginalise_oldest(Window& window, double huber_sd);

/// Lets a landmark, bias or tau wander: its variance [m^2, s^2] grows by this much for all that
/// comes, given what is known of it outside the live ranges.
void relax(Window& window, GlobalId id, double variance);

}  // namespace rali::graph
