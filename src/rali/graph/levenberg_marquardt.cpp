#include "rali/graph/levenberg_marquardt.hpp"

#include <algorithm>
#include <limits>

namespace rali::graph {

namespace {

constexpr double kLambdaFactor = 10.0;
constexpr double kLambdaMax = 1e10;
// An unknown without any factor has a zero on the diagonal; the floor prevents a division by it.
constexpr double kDiagonalFloor = 1e-9;
// Costs below this are rounding of an exact fit.
constexpr double kCostFloor = 1e-9;
/// Lower damping would let rounding move an unobservable direction. Higher damping, scaled by one
/// very stiff factor, would hold everything coupled to it: INTEL's information spans eleven
/// decades.
constexpr double kLambdaMin = 1e-15;
constexpr double kLeverM = 10.0;  ///< lever arm that converts a node's rotation into a displacement

/// The largest change of a position, landmark or range bias [m].
double farthest_m(const Window& window, const Eigen::VectorXd& step) {
  double farthest = 0.0;
  Eigen::Index at = 0;
  for (const KeyframeNode& keyframe : window.keyframes) {
    if (keyframe.fixed) continue;
    const double turn_m = kLeverM * step.segment<3>(at + kTheta).norm();
    farthest = std::max(farthest, step.segment<3>(at + kPos).norm() + turn_m);
    at += keyframe.dim;
  }
  for (const GlobalNode& global : window.globals) {
    if (global.id.kind != GlobalKind::kTau) {
      farthest = std::max(farthest, step.segment(at, global.dim()).norm());
    }
    at += global.dim();
  }
  return farthest;
}

/// Very stiff factors curve the valley, and a straight step leaves it quadratically. So a step that
/// raised the cost is rejected only if a second one does not compensate it. The equations are then
/// those after the first step.
/// @return the final cost; NaN if there is no step
double cost_of_second_step(Window& window, NormalEquations& equations, double huber_sd,
                           double relative, double absolute) {
  equations.relinearise(window, huber_sd);
  if (!equations.factorise(relative, absolute)) return std::numeric_limits<double>::quiet_NaN();
  window.move(equations.solve(-equations.gradient()));
  return total_cost(window, huber_sd);
}

}  // namespace

double total_cost(const Window& window, double huber_sd) {
  double cost = 0.0;
  for_each_factor(window, huber_sd, [&cost](const LinearFactor& f) { cost += f.cost; });
  if (window.dense.H.rows() > 0) cost += graph::cost(window, window.dense);
  return cost;
}

SolveReport levenberg_marquardt(Window& window, NormalEquations& equations,
                                const GraphSettings& settings, StopFlag stop, int iterations_max) {
  SolveReport report;
  double cost = equations.cost();
  double lambda = settings.lambda_initial;
  report.cost_before = cost;
  SavedValues saved;
  while (report.iterations < iterations_max && !report.converged && !stop.raised()) {
    ++report.iterations;
    bool better = false;
    double fall = 0.0;
    if (equations.factorise(lambda, lambda * kDiagonalFloor)) {
      const Eigen::VectorXd step = equations.solve(-equations.gradient());
      saved.save(window);
      window.move(step);
      fall = cost - total_cost(window, settings.huber_sd);
      better = step.allFinite() && fall >= 0.0;
      if (!better && -fall <= cost) {
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
      // A negligible step ends the iteration, even if rounding raises the cost.
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
