#pragma once

#include "rali/graph/settings.hpp"
#include "rali/graph/window.hpp"

namespace rali::graph {

struct SolveReport {
  int iterations = 0;  ///< steps tried
  double cost_before = 0.0;
  double cost_after = 0.0;
  bool converged = false;       ///< stopped by cost or step, not by the number of iterations
  bool rotation_first = false;  ///< of a fleet: the start was made anew (rotation_start.hpp)
};

/// Half the squared residuals in sigma, with the robust loss on ranges.
[[nodiscard]] double total_cost(const Window& window, double huber_sd);

/// Levenberg-Marquardt on all values of the window (algorithms 6.3): damping times the diagonal,
/// x 10 after a step that made it worse, / 10 after a good one. It ends when the cost falls by less
/// than the settings' fraction or no position, landmark or bias moves as far as their step.
SolveReport solve(Window& window, const LocalGraphSettings& settings, int iterations_max);

}  // namespace rali::graph
