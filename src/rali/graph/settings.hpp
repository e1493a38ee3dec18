#pragma once

#include "rali/base/settings.hpp"

namespace rali::graph {

/// Protection against wrong loops (algorithms_fleet 8.4).
enum class LoopGuard {
  kNone,   ///< all loops count
  kHuber,  ///< loops with large residuals get less weight
  kDcs,    ///< likewise, with still less weight (dynamic covariance scaling)
  kGnc     ///< loops count fully or not at all (graduated non-convexity, truncated least squares)
};

inline constexpr ChoiceNames<4> kLoopGuardNames{"none", "huber", "dcs", "gnc"};

/// Settings of the pose graph of a fleet (algorithms_fleet 8).
struct GraphSettings {
  LoopGuard guard = LoopGuard::kGnc;
  int iterations = 50;
  double huber_sd = 2.0;
  double lambda_initial = 1e-6;
  double cost_change_min = 1e-5;
  double step_min_m = 1e-4;
  double start_chi2_per_dof = 10.0;
  int guard_rounds = 100;
  int guard_iterations = 2;
  double gnc_factor = 1.4;
  double veto_exact_from = 8.0;
  double veto_exact_to = 40.0;

  template <class V>
  void visit(V& v) {
    v.choice("guard", guard, kLoopGuardNames, "what is done against wrong loops");
    v("iterations", iterations, 1, 1000, "Levenberg-Marquardt steps of a full solve, at most");
    v("huber_sd", huber_sd, 0.5, 1e6,
      "residuals of ranges beyond so many sigma get a lower weight");
    v("lambda_initial", lambda_initial, 1e-12, 1.0, "damping of the first step");
    v("cost_change_min", cost_change_min, 0.0, 0.1, "stop when the cost falls by less (relative)");
    v("step_min_m", step_min_m, 0.0, 0.1, "stop when nothing moves farther");
    v("start_chi2_per_dof", start_chi2_per_dof, 0.0, 1e12,
      "a start that fits worse is computed again, rotations first");
    v("guard_rounds", guard_rounds, 1, 1000, "largest number of weightings of the loops");
    v("guard_iterations", guard_iterations, 1, 100, "Levenberg-Marquardt steps between");
    v("gnc_factor", gnc_factor, 1.01, 10.0, "by which gnc sharpens its switch each time");
    v("veto_exact_from", veto_exact_from, 0.0, 1e6,
      "predicted chi2 from which a loop that would be refused, or turns paths far, is tried in the "
      "graph");
    v("veto_exact_to", veto_exact_to, 0.0, 1e6, "and up to which; beyond it is wrong anyway");
  }
};

}  // namespace rali::graph
