#pragma once

#include <algorithm>

#include "rali/graph/solver.hpp"

namespace rali::graph {

struct LevenbergMarquardtSettings {
  double huber_sd = 2.0;
  double lambda_initial = 1e-6;
  double cost_change_min = 1e-4;  ///< relative
  double step_min_m = 1e-4;
};

[[nodiscard]] LevenbergMarquardtSettings steps_of(const LocalGraphSettings& settings);
[[nodiscard]] LevenbergMarquardtSettings steps_of(const GlobalGraphSettings& settings);

/// The farthest that a position, landmark or range bias moves [m].
[[nodiscard]] double farthest_m(const Window& window, const Eigen::VectorXd& step);

/// The values of a window, to go back to. Factors stay.
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

/// Steps on all values of the window until nothing gets better, see solve() in solver.hpp. The
/// equations are those of the window at its present values.
template <class Equations>
SolveReport levenberg_marquardt(Window& window, Equations& equations,
                                const LevenbergMarquardtSettings& settings, int iterations_max) {
  constexpr double kLambdaFactor = 10.0;
  // Below it, the damping would not keep a direction that nothing holds from moving by rounding.
  constexpr double kLambdaMin = 1e-9;
  constexpr double kLambdaMax = 1e10;
  // An unknown without any factor has a zero on the diagonal; it must not divide by it.
  constexpr double kDiagonalFloor = 1e-9;
  // Costs below this are rounding of a perfect fit.
  constexpr double kCostFloor = 1e-9;
  SolveReport report;
  double cost = equations.cost();
  double lambda = settings.lambda_initial;
  report.cost_before = cost;
  SavedValues saved;
  while (report.iterations < iterations_max && !report.converged) {
    ++report.iterations;
    bool better = false;
    double fall = 0.0;
    if (equations.factorise(lambda, lambda * kDiagonalFloor)) {
      const Eigen::VectorXd step = equations.solve(-equations.gradient());
      saved.save(window);
      window.move(step);
      fall = cost - total_cost(window, settings.huber_sd);
      better = step.allFinite() && fall >= 0.0;
      if (!better) saved.restore(window);
      // A step too small to matter ends it, even when rounding lets the cost rise.
      if (step.allFinite() && farthest_m(window, step) < settings.step_min_m) {
        report.converged = true;
      }
    }
    if (better) {
      report.converged =
          report.converged || fall <= settings.cost_change_min * std::max(cost, kCostFloor);
      cost -= fall;
      lambda = std::max(lambda / kLambdaFactor, kLambdaMin);
      if (!report.converged) equations.relinearise(window, settings.huber_sd);
    } else {
      lambda *= kLambdaFactor;
      if (lambda > kLambdaMax) break;
    }
  }
  report.cost_after = cost;
  return report;
}

}  // namespace rali::graph
