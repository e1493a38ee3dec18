// Veto of a loop by the graph without loops (algorithms_fleet 8.4).
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

/// The graph without loops at its minimum, factored once for all the loops that are asked about.
class LoopJudge {
 public:
  LoopJudge(const Window& window, const GraphSettings& settings, StopFlag stop);

  [[nodiscard]] LoopVerdict verdict(const RelativePoseFactor& loop);

 private:
  [[nodiscard]] std::optional<double> cost_with(const RelativeTerm& loop, double rise_enough);
  [[nodiscard]] double cost_anew(const RelativeTerm& loop) const;

  const GraphSettings& settings_;
  StopFlag stop_;
  Window graph_;
  NormalEquations equations_;  ///< factored at the minimum
  double cost_ = 0.0;
  bool factored_ = false;
};

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

// e'(J P J' + R)^-1 e, with residual and J divided by sigma: then R is 1 in the directions that the
// loop claims, and the others are zero in e and J and add nothing.
LoopVerdict LoopJudge::verdict(const RelativePoseFactor& loop) {
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
  verdict.chi2 = S.allFinite() ? e.dot(S.ldlt().solve(e)) : 0.0;
  if (verdict.chi2 >= settings_.veto_exact_from && verdict.chi2 <= settings_.veto_exact_to) {
    const std::optional<double> with = cost_with(term, 0.5 * loop_chi2_veto(verdict.dof));
    verdict.chi2 = 2.0 * ((with ? *with : cost_anew(term)) - cost_);
    verdict.exact = true;
  }
  return verdict;
}

/// The minimum with the loop, by steps with the curvature that the graph has without it and the
/// loop's own on top (Woodbury): the loop moves things by their doubt, and over that the curvature
/// is nearly the same. A factorisation for each loop would take nearly all the time of a long
/// mission.
/// @param rise_enough where the cost has risen by no more than this the minimum has not either, and
/// need not be found
/// @return nothing where these steps do not come to rest
std::optional<double> LoopJudge::cost_with(const RelativeTerm& loop, double rise_enough) {
  constexpr int kStepsMax = 20;
  constexpr double kFallMin = 1e-3;  // chi2 to a hundredth of what decides
  SavedValues minimum;
  minimum.save(graph_);
  Eigen::VectorXd gradient = equations_.gradient();
  LinearFactor rows;
  linearise(graph_, loop, rows);
  double cost = cost_ + rows.cost;
  std::optional<double> rest;
  for (int k = 0; k < kStepsMax && !rest; ++k) {
    const MatrixXd Jt = equations_.right_of(rows);
    MatrixXd right(Jt.rows(), Jt.cols() + 1);
    right << Jt, gradient + Jt * rows.r;
    const MatrixXd solved = equations_.solve(right);
    const auto V = solved.leftCols(Jt.cols());
    const Eigen::VectorXd y = solved.rightCols<1>();
    const MatrixXd S = MatrixXd::Identity(Jt.cols(), Jt.cols()) + Jt.transpose() * V;
    graph_.move(V * S.ldlt().solve(Jt.transpose() * y) - y);
    const NormalEquations::Slope slope = equations_.slope(graph_, settings_.huber_sd);
    linearise(graph_, loop, rows);
    const double fall = cost - (slope.cost + rows.cost);
    if (!(fall >= -kFallMin)) break;
    cost -= fall;
    gradient = slope.gradient;
    if (fall <= kFallMin || cost - cost_ <= rise_enough) rest = cost;
  }
  minimum.restore(graph_);
  return rest;
}

double LoopJudge::cost_anew(const RelativeTerm& loop) const {
  Window with = graph_;
  with.relative.push_back(loop);
  NormalEquations equations(with, settings_.huber_sd);
  return levenberg_marquardt(with, equations, settings_, stop_, settings_.iterations).cost_after;
}

}  // namespace

std::vector<LoopVerdict> judge_loops(const Window& window, const GraphSettings& settings,
                                     const std::vector<RelativePoseFactor>& loops, StopFlag stop) {
  std::vector<LoopVerdict> verdicts;
  if (loops.empty()) return verdicts;
  LoopJudge judge(window, settings, stop);
  for (const RelativePoseFactor& loop : loops) {
    verdicts.push_back(stop.raised() ? LoopVerdict{} : judge.verdict(loop));
  }
  return verdicts;
}

}  // namespace rali::graph
