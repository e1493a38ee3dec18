#pragma once

#include "rali/base/stop_flag.hpp"
#include "rali/graph/normal_equations.hpp"
#include "rali/graph/settings.hpp"

namespace rali::graph {

struct SolveReport {
  int iterations = 0;  ///< steps tried
  double cost_before = 0.0;
  double cost_after = 0.0;
  bool converged = false;       ///< stopped by cost or step, not by the number of iterations
  bool rotation_first = false;  ///< the initial values were recomputed (rotation_start.hpp)
};

/// Half the squared residuals in sigma, with the robust loss on ranges.
[[nodiscard]] double total_cost(const Window& window, double huber_sd);

/// The values of a window, for restoring them. Factors are not saved.
struct SavedValues {
  std::vector<KeyframeNode> keyframes;
  std::vector<GlobalNode> globals;

  void save(const Window& window) {
    keyframes = window.keyframes;
    globals = window.globals;
  }

  void restore(Window& window) const {
    window.keyframes = keyframes;
    window.globals = globals;
  }
};

/// Levenberg-Marquardt on all values of the window (algorithms 6.3): damping times the diagonal, x
/// 10 after a step that raised the cost, / 10 after one that lowered it. It ends when the cost
/// falls by less than the settings' fraction or no position, landmark or bias moves as far as their
/// step.
/// @param equations of the window at its present values
/// @param stop checked before each step
SolveReport levenberg_marquardt(Window& window, NormalEquations& equations,
                                const GraphSettings& settings, StopFlag stop, int iterations_max);

}  // namespace rali::graph
