#include "rali/graph/solver.hpp"

#include <algorithm>

#include "rali/graph/normal_equations.hpp"

namespace rali::graph {

namespace {

constexpr double kLambdaFactor = 10.0;
// Below it, the damping would not keep a direction that nothing holds from moving by rounding.
constexpr double kLambdaMin = 1e-9;
constexpr double kLambdaMax = 1e10;
// An unknown without any factor has a zero on the diagonal; it must not divide by it.
constexpr double kDiagonalFloor = 1e-9;
// Costs below this are rounding of a perfect fit.
constexpr double kCostFloor = 1e-9;

// The farthest that a position, landmark or range bias moves [m].
double farthest_m(const Window& window, const Eigen::VectorXd& step) {
  double farthest = 0.0;
  for (std::size_t k = 0; k < window.keyframes.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k) * kStateDim + kPos;
    farthest = std::max(farthest, step.segment<3>(at).norm());
  }
  Eigen::Index at = window.keyframe_columns();
  for (const GlobalNode& global : window.globals) {
    if (global.id.kind != GlobalKind::kTau) {
      farthest = std::max(farthest, step.segment(at, global.dim()).norm());
    }
    at += global.dim();
  }
  return farthest;
}

// The values of a window, to go back to. Factors stay.
struct Values {
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

}  // namespace

double total_cost(const Window& window, double huber_sd) {
  double cost = 0.0;
  for_each_factor(window, huber_sd, [&cost](const LinearFactor& f) { cost += f.cost; });
  if (window.dense.H.rows() > 0) cost += linearise(window, window.dense).cost;
  return cost;
}

SolveReport solve(Window& window, const LocalGraphSettings& settings, int iterations_max) {
  SolveReport report;
  if (window.keyframes.empty()) return report;
  NormalEquations equations(window, settings.huber_sd);
  double cost = equations.cost();
  double lambda = settings.lambda_initial;
  report.cost_before = cost;
  Values saved;
  while (report.iterations < iterations_max && !report.converged) {
    ++report.iterations;
    bool better = false;
    double fall = 0.0;
    double moved_m = 0.0;
    if (equations.factorise(lambda, lambda * kDiagonalFloor)) {
      const Eigen::VectorXd step = equations.solve(-equations.gradient());
      saved.save(window);
      window.move(step);
      const double cost_there = total_cost(window, settings.huber_sd);
      moved_m = farthest_m(window, step);
      fall = cost - cost_there;
      better = step.allFinite() && fall >= 0.0;
      if (!better) saved.restore(window);
      // A step too small to matter ends it, even when rounding lets the cost rise.
      if (step.allFinite() && moved_m < settings.step_min_m) report.converged = true;
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
