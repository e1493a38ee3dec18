#pragma once

#include <vector>

#include "rali/graph/window.hpp"

namespace rali::graph {

/// Converts all factors of the nodes into the dense prior on the other nodes, landmarks, biases and
/// taus of those factors, and removes the nodes (algorithms_fleet 8.5, T19). Linearised at the
/// present values; loops count with their present weight, and those switched off are lost. A fixed
/// node that remains is not in the prior.
/// @param nodes  ascending, without repetition; not all nodes of the window
void marginalise(Window& window, const std::vector<Seq>& nodes, double huber_sd);

/// A quadratic cost + b.d + d.H d/2.
struct Quadratic {
  Eigen::MatrixXd H;
  Eigen::VectorXd b;
  double cost = 0.0;
};

/// Removes rounding noise from a quadratic that should be positive semidefinite: directions with
/// less than 1e-9 of the strongest one's information (each unknown scaled to its own) lose both
/// information and gradient.
void drop_rounding(Quadratic& quadratic);

}  // namespace rali::graph
