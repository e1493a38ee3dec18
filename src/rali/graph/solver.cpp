#include "rali/graph/solver.hpp"

#include "rali/graph/global_equations.hpp"
#include "rali/graph/levenberg_marquardt.hpp"
#include "rali/graph/normal_equations.hpp"

namespace rali::graph {

namespace {

// INTEL's information spans eleven decades.
constexpr double kLambdaMinLocal = 1e-9;
constexpr double kLambdaMinGlobal = 1e-15;
constexpr double kLeverM = 10.0;
/// A landmark fills in from where it was heard to the end of the band. So many unknowns of the
/// border are worth an order of least fill: a kilometre of tunnel has hundreds of places at which
/// somebody stood, and one factorisation took a minute.
constexpr int kBorderWide = 100;

}  // namespace

LevenbergMarquardtSettings steps_of(const LocalGraphSettings& s) {
  return {
      s.huber_sd, s.lambda_initial, s.cost_change_min, s.step_min_m, kLambdaMinLocal, false, 0.0,
      {}};
}

LevenbergMarquardtSettings steps_of(const GlobalGraphSettings& s, StopFlag stop) {
  return {s.huber_sd,        s.lambda_initial,
          s.cost_change_min, s.step_min_m,
          kLambdaMinGlobal,  true,
          kLeverM,           stop};
}

double farthest_m(const Window& window, const Eigen::VectorXd& step, double lever_m) {
  double farthest = 0.0;
  Eigen::Index at = 0;
  for (const KeyframeNode& keyframe : window.keyframes) {
    if (keyframe.fixed) continue;
    const double turn_m = lever_m * step.segment<3>(at + kTheta).norm();
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

double total_cost(const Window& window, double huber_sd) {
  double cost = 0.0;
  for_each_factor(window, huber_sd, [&cost](const LinearFactor& f) { cost += f.cost; });
  if (window.dense.H.rows() > 0) cost += graph::cost(window, window.dense);
  return cost;
}

SolveReport solve(Window& window, const LocalGraphSettings& settings, int iterations_max) {
  if (window.keyframes.empty()) return {};
  if (window.columns() - window.keyframe_columns() > kBorderWide) {
    GlobalEquations equations(window, settings.huber_sd);
    return levenberg_marquardt(window, equations, steps_of(settings), iterations_max);
  }
  NormalEquations equations(window, settings.huber_sd);
  return levenberg_marquardt(window, equations, steps_of(settings), iterations_max);
}

}  // namespace rali::graph
