#pragma once

#include <vector>

#include "rali/graph/window.hpp"

namespace rali::graph {

/// Puts all factors that touch the nodes into the dense prior, on the other nodes, landmarks,
/// biases and taus that those factors touch, and removes the nodes, with each retired global that
/// no other range uses (algorithms_fleet 8.5, T19). Linearised at the present values; loops count
/// with their present weight, and those switched off are lost. A node that stays and is fixed has
/// no part in the prior.
/// @param nodes  growing, without repetition; not all nodes of the window
void marginalise(Window& window, const std::vector<Seq>& nodes, double huber_sd);

}  // namespace rali::graph
