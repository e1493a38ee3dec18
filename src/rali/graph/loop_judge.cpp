// Veto of a loop by the graph without loops (algorithms_fleet 8.4).
#include <Eigen/Cholesky>

#include "rali/graph/checks.hpp"
#include "rali/graph/global_marginals.hpp"
#include "rali/graph/levenberg_marquardt.hpp"
#include "rali/graph/loops.hpp"

namespace rali::graph {

namespace {

// e'(J P J' + R)^-1 e, with residual and J divided by sigma: then R is 1 in the directions that the
// loop claims, and the others are zero in e and J and add nothing.
LoopVerdict predict(const Window& window, const GlobalMarginals& marginals,
                    const RelativeTerm& term) {
  RelativeTerm plain = term;
  plain.root.setIdentity();
  LinearFactor rows;
  linearise(window, plain, rows);
  LoopVerdict verdict;
  verdict.dof = rank(term);
  verdict.T_i_j =
      window.node(term.f.i).x.T_odom_body.inverse() * window.node(term.f.j).x.T_odom_body;
  verdict.covariance = marginals.covariance(rows);
  const geometry::Vec6 e = term.root * rows.r;
  const geometry::Mat6 S =
      term.root * verdict.covariance * term.root.transpose() + geometry::Mat6::Identity();
  verdict.chi2 = S.allFinite() ? e.dot(S.ldlt().solve(e)) : 0.0;
  return verdict;
}

}  // namespace

std::vector<LoopVerdict> judge_loops(const Window& window, const GlobalGraphSettings& settings,
                                     const std::vector<RelativePoseFactor>& loops) {
  Window without = window;
  without.loops.clear();
  const auto solve = [&](Window& graph) {
    GlobalEquations equations(graph, settings.huber_sd);
    return levenberg_marquardt(graph, equations, steps_of(settings), settings.iterations);
  };
  const double cost = solve(without).cost_after;
  const GlobalMarginals marginals(without, settings.huber_sd);
  std::vector<LoopVerdict> verdicts;
  for (const RelativePoseFactor& loop : loops) {
    const RelativeTerm term = with_root(without, loop);
    LoopVerdict verdict = predict(without, marginals, term);
    if (verdict.chi2 >= settings.veto_exact_from && verdict.chi2 <= settings.veto_exact_to) {
      Window with = without;
      with.relative.push_back(term);
      verdict.chi2 = 2.0 * (solve(with).cost_after - cost);
      verdict.exact = true;
    }
    verdicts.push_back(verdict);
  }
  return verdicts;
}

}  // namespace rali::graph
