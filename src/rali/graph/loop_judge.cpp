// Veto of a loop by the graph without loops (algorithms_fleet 8.4).
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Cholesky>

#include "rali/graph/checks.hpp"
#include "rali/graph/levenberg_marquardt.hpp"
#include "rali/graph/loops.hpp"
#include "rali/graph/marginals.hpp"
#include "rali/graph/normal_equations.hpp"

namespace rali::graph {

namespace {

using Eigen::MatrixXd;
using geometry::Mat6;

/// If the predicted step turns no node by more, the quadratic prediction is not too low: a robust
/// loss rises more slowly than its quadratic, and the second-order effect of this turn is 2 cm at
/// 100 m.
constexpr double kStraight_rad = 0.02;

/// The graph without loops at its minimum, factored once for all loop candidates.
class LoopJudge {
 public:
  LoopJudge(const Window& window, const GraphSettings& settings, StopFlag stop);

  /// Safe to call concurrently.
  [[nodiscard]] LoopVerdict verdict(const RelativePoseFactor& loop) const;

 private:
  [[nodiscard]] double cost_with(const RelativeTerm& loop, double rise_enough) const;
  [[nodiscard]] double cost_anew(const RelativeTerm& loop) const;

  const GraphSettings& settings_;
  StopFlag stop_;
  Window graph_;
  NormalEquations equations_;  ///< factored at the minimum
  double cost_ = 0.0;
  bool factored_ = false;
};

/// Steps from the graph's minimum towards the one with a loop: Gauss-Newton steps with the graph's
/// curvature without it plus the loop's own (Woodbury).
class StepsWithLoop {
 public:
  StepsWithLoop(Window graph, const RelativeTerm& loop, double huber_sd)
      : graph_(std::move(graph)), loop_(loop), huber_sd_(huber_sd) {
    look();
  }

  [[nodiscard]] double cost() const { return slope_.cost + rows_.cost; }

  [[nodiscard]] const Window& graph() const { return graph_; }

  /// @param equations factored, of this graph without the loop  @return decrease of the cost
  double step(const NormalEquations& equations);

 private:
  void look() {
    slope_ = NormalEquations::slope(graph_, huber_sd_);
    linearise(graph_, loop_, rows_);
  }

  Window graph_;
  const RelativeTerm& loop_;
  double huber_sd_;
  NormalEquations::Slope slope_;
  LinearFactor rows_;
};

double StepsWithLoop::step(const NormalEquations& equations) {
  const double before = cost();
  const MatrixXd Jt = equations.right_of(rows_);
  MatrixXd right(Jt.rows(), Jt.cols() + 1);
  right << Jt, slope_.gradient + Jt * rows_.r;
  const MatrixXd solved = equations.solve(right);
  const auto V = solved.leftCols(Jt.cols());
  const Eigen::VectorXd y = solved.rightCols<1>();
  const MatrixXd S = MatrixXd::Identity(Jt.cols(), Jt.cols()) + Jt.transpose() * V;
  graph_.move(V * S.ldlt().solve(Jt.transpose() * y) - y);
  look();
  return before - cost();
}

Window without_loops(Window window) {
  window.loops.clear();
  return window;
}

LoopJudge::LoopJudge(const Window& window, const GraphSettings& settings, StopFlag stop)
    : settings_(settings),
      stop_(stop),
      graph_(without_loops(window)),
      equations_(graph_, settings.huber_sd) {
  levenberg_marquardt(graph_, equations_, settings, stop, settings.iterations);
  equations_.relinearise(graph_, settings.huber_sd);
  cost_ = equations_.cost();
  factored_ = factorise_with_floor(equations_);
}

/// The largest rotation of a node in a step [rad].
double farthest_rad(const Window& window, const Eigen::VectorXd& step) {
  double farthest = 0.0;
  for (const KeyframeNode& node : window.keyframes) {
    if (node.fixed) continue;
    farthest = std::max(farthest, step.segment<3>(window.column(node.seq) + kTheta).norm());
  }
  return farthest;
}

// e'(J P J' + R)^-1 e, with residual and J divided by sigma: then R is 1 in the directions that the
// loop constrains, and the others are zero in e and J and add nothing.
LoopVerdict LoopJudge::verdict(const RelativePoseFactor& loop) const {
  const RelativeTerm term = with_root(graph_, loop);
  RelativeTerm plain = term;
  plain.root.setIdentity();
  LinearFactor rows;
  linearise(graph_, plain, rows);
  LoopVerdict verdict;
  verdict.dof = rank(term);
  verdict.T_i_j = graph_.node(loop.i).x.T_odom_body.inverse() * graph_.node(loop.j).x.T_odom_body;
  if (!factored_) {
    verdict.covariance.setZero();
    verdict.covariance.diagonal().setConstant(std::numeric_limits<double>::infinity());
    return verdict;
  }
  verdict.covariance = equations_.covariance(rows);
  const geometry::Vec6 e = term.root * rows.r;
  const Mat6 S = term.root * verdict.covariance * term.root.transpose() + Mat6::Identity();
  if (!S.allFinite()) return verdict;
  const geometry::Vec6 weighted = S.ldlt().solve(e);
  verdict.chi2 = e.dot(weighted);
  if (verdict.chi2 < settings_.veto_exact_from || verdict.chi2 > settings_.veto_exact_to) {
    return verdict;
  }
  if (!verdict.vetoed()) {
    const Eigen::VectorXd step =
        equations_.solve(equations_.right_of(rows) * (term.root.transpose() * weighted));
    if (farthest_rad(graph_, step) < kStraight_rad) return verdict;
  }
  verdict.chi2 = 2.0 * (cost_with(term, 0.5 * loop_chi2_veto(verdict.dof)) - cost_);
  verdict.exact = true;
  return verdict;
}

/// The minimum with the loop. The loop moves nodes within their uncertainty, where the curvature is
/// nearly constant. So the existing factorisation is used; one per loop would take nearly all the
/// time of a long mission. It is recomputed, for the same pattern, only if these steps do not
/// converge.
/// @param rise_enough if the cost has risen by no more than this, neither has the minimum, and the
/// iteration ends
double LoopJudge::cost_with(const RelativeTerm& loop, double rise_enough) const {
  constexpr int kStepsMax = 20, kAnewMax = 8;
  constexpr double kFallMin = 1e-3;  // chi2 to a hundredth of what decides
  StepsWithLoop steps(graph_, loop, settings_.huber_sd);
  const auto rests = [&](double fall) {
    return std::abs(fall) <= kFallMin || steps.cost() - cost_ <= rise_enough;
  };
  for (int k = 0; k < kStepsMax; ++k) {
    const double fall = steps.step(equations_);
    if (rests(fall)) return steps.cost();
    // The first step leaves a valley curved by stiff factors; the next one compensates that.
    if (k > 0 && !(fall >= 0.0)) break;
  }
  NormalEquations equations = equations_;
  for (int k = 0; k < kAnewMax; ++k) {
    equations.relinearise(steps.graph(), settings_.huber_sd);
    if (!factorise_with_floor(equations)) break;
    const double fall = steps.step(equations);
    if (rests(fall)) return steps.cost();
    if (!(fall >= 0.0)) break;
  }
  return cost_anew(loop);
}

double LoopJudge::cost_anew(const RelativeTerm& loop) const {
  Window with = graph_;
  with.relative.push_back(loop);
  NormalEquations equations(with, settings_.huber_sd);
  return levenberg_marquardt(with, equations, settings_, stop_, settings_.iterations).cost_after;
}

}  // namespace

std::vector<LoopVerdict> judge_loops(const Window& window, const GraphSettings& settings,
                                     const std::vector<RelativePoseFactor>& loops,
                                     Executor& executor, StopFlag stop) {
  std::vector<LoopVerdict> verdicts(loops.size());
  if (loops.empty()) return verdicts;
  const LoopJudge judge(window, settings, stop);
  executor.for_blocks(loops.size(), 1, [&](std::size_t k, std::size_t, std::size_t) {
    if (!stop.raised()) verdicts[k] = judge.verdict(loops[k]);
  });
  return verdicts;
}

}  // namespace rali::graph
