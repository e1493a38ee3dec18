#pragma once

#include <vector>

#include "rali/graph/window.hpp"

namespace rali::graph {

/// Puts all factors that touch the nodes into the dense prior, on the other nodes, landmarks,
/// biases and taus that those factors touch, and removes the nodes (algorithms_fleet 8.5, T19).
/// Linearised at the present values; loops count with their present weight, and those switched off
/// are lost. A node that stays and is fixed has no part in the prior.
/// @param nodes  growing, without repetition; not all nodes of the window
void marginalise(Window& window, const std::vector<Seq>& nodes, double huber_sd);

/// A quadratic cost + b.d + d.H d/2.
struct Quadratic {
  Eigen::MatrixXd H;
  Eigen::VectorXd b;
  double cost = 0.0;
};

/// Takes noise out of a quadratic that should be positive semidefinite: directions with less than
/// 1e-9 of the information of the strongest (each unknown scaled to its own) lose both information
/// and pull.
void drop_rounding(Quadratic& quadratic);

}  // namespace rali::graph
