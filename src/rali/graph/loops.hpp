#pragma once

#include "rali/base/executor.hpp"
#include "rali/base/stop_flag.hpp"
#include "rali/graph/levenberg_marquardt.hpp"
#include "rali/graph/normal_equations.hpp"
#include "rali/graph/settings.hpp"

namespace rali::graph {

/// chi2 that a correct measurement of this many directions (0 to 6) exceeds in 1 % of cases; 0 for
/// 0.
[[nodiscard]] double loop_chi2_gate(int dof);

/// The same for 0.1 %: the veto's limit.
[[nodiscard]] double loop_chi2_veto(int dof);

/// Weight of a loop whose squared residual is q times its gate, in graduated non-convexity for
/// truncated least squares with control mu (Yang et al. 2020, eq. 14; algorithms_fleet 8.4, T18).
[[nodiscard]] double gnc_weight(double q, double mu);

/// First mu, given the largest q; none if all loops fit from the start.
[[nodiscard]] std::optional<double> gnc_first_mu(double q_max);

/// Squared residual of a loop at the present values, without its weight.
[[nodiscard]] double loop_chi2(const Window& window, const LoopTerm& loop);

/// Solves with loop weights chosen by the guard, and leaves both in the window. Other factors are
/// never switched off. The window must be laid out.
SolveReport solve_with_guard(Window& window, const GraphSettings& settings, StopFlag stop = {});

/// Consistency of a loop with a graph that does not contain it.
struct LoopVerdict {
  /// Twice the rise of the graph's minimum with the loop. An upper bound if no veto; without a
  /// trial it may be too low by a few hundredths.
  double chi2 = 0.0;
  int dof = 0;         ///< directions that the loop constrains
  bool exact = false;  ///< computed by solving with the loop, not predicted
  /// Relative pose predicted by the graph, and the covariance of geometry::RelativePoseFactor's
  /// residual: rotation in j, translation in i.
  geometry::SE3 T_i_j;
  geometry::Mat6 covariance = geometry::Mat6::Zero();

  [[nodiscard]] bool vetoed() const { return chi2 > loop_chi2_veto(dof); }
};

/// PoseGraph::judge on a window that is laid out.
[[nodiscard]] std::vector<LoopVerdict> judge_loops(const Window& window,
                                                   const GraphSettings& settings,
                                                   const std::vector<RelativePoseFactor>& loops,
                                                   Executor& executor, StopFlag stop = {});

}  // namespace rali::graph
