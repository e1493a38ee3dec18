#pragma once

#include <algorithm>
#include <limits>

#include "rali/base/stop_flag.hpp"
#include "rali/graph/solver.hpp"

namespace rali::graph {

struct LevenbergMarquardtSettings {
  double huber_sd = 2.0;
  double lambda_initial = 1e-6;
  double cost_change_min = 1e-4;  ///< relative
  double step_min_m = 1e-4;
  /// Below it, the damping would not keep a direction that nothing holds from moving by rounding;
  /// above it, the damping of one very stiff factor holds all that hangs on it.
  double lambda_min = 1e-9;
  /// A step that made it worse is given up only if a second one from there does not mend it: very
  /// stiff factors bend the valley, and a straight step leaves it by its square.
  bool second_step = false;
  double lever_m = 0.0;  ///< a turn of a node counts as what it moves at this distance
  StopFlag stop;         ///< asked before each iteration
};

[[nodiscard]] LevenbergMarquardtSettings steps_of(const LocalGraphSettings& settings);
[[nodiscard]] LevenbergMarquardtSettings steps_of(const GlobalGraphSettings& settings,
                                                  StopFlag stop = {});

/// The farthest that a position, landmark or range bias moves [m], turns counted at `lever_m`.
[[nodiscard]] double farthest_m(const Window& window, const Eigen::VectorXd& step, double lever_m);

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

/// A second step from where one has made it worse. The equations are those of that place then.
/// @return what the cost is at the end; NaN if there is no step
template <class Equations>
double cost_of_second_step(Window& window, Equations& equations, double huber_sd, double relative,
                           double absolute) {
  equations.relinearise(window, huber_sd);
  if (!equations.factorise(relative, absolute)) return std::numeric_limits<double>::quiet_NaN();
  window.move(equations.solve(-equations.gradient()));
  return total_cost(window, huber_sd);
}

/// Steps on all values of the window until nothing gets better, see solve() in solver.hpp. The
/// equations are those of the window at its present values.
template <class Equations>
SolveReport levenberg_marquardt(Window& window, Equations& equations,
                                const LevenbergMarquardtSettings& settings, int iterations_max) {
  constexpr double kLambdaFactor = 10.0;
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
  while (report.iterations < iterations_max && !report.converged && !settings.stop.raised()) {
    ++report.iterations;
    bool better = false;
    double fall = 0.0;
    if (equations.factorise(lambda, lambda * kDiagonalFloor)) {
      const Eigen::VectorXd step = equations.solve(-equations.gradient());
      saved.save(window);
      window.move(step);
      fall = cost - total_cost(window, settings.huber_sd);
      better = step.allFinite() && fall >= 0.0;
      if (!better && settings.second_step && -fall <= cost) {
        fall = cost - cost_of_second_step(window, equations, settings.huber_sd, lambda,
                                          lambda * kDiagonalFloor);
        better = fall >= 0.0;
        if (!better) {
          saved.restore(window);
          equations.relinearise(window, settings.huber_sd);
        }
      } else if (!better) {
        saved.restore(window);
      }
      // A step too small to matter ends it, even when rounding lets the cost rise.
      if (step.allFinite() && farthest_m(window, step, settings.lever_m) < settings.step_min_m) {
        report.converged = true;
      }
    }
    if (better) {
      report.converged =
          report.converged || fall <= settings.cost_change_min * std::max(cost, kCostFloor);
      cost -= fall;
      lambda = std::max(lambda / kLambdaFactor, settings.lambda_min);
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
