#include "rali/graph/loops.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "rali/base/assert.hpp"
#include "rali/geometry/robust.hpp"
#include "rali/graph/levenberg_marquardt.hpp"
#include "rali/graph/rotation_start.hpp"

namespace rali::graph {

namespace {

// Smaller weight changes count as converged.
constexpr double kWeightChangeMin = 1e-3;

double quantile(const std::array<double, 7>& table, int dof) {
  RALI_ASSERT(dof >= 0 && dof <= 6);
  return table[static_cast<std::size_t>(dof)];
}

void add(const SolveReport& step, SolveReport& sum) {
  sum.iterations += step.iterations;
  sum.cost_after = step.cost_after;
  sum.converged = step.converged;
}

// q of each loop: squared residual over its gate. A loop without any constraint has q = 0.
std::vector<double> fractions(const Window& window) {
  std::vector<double> q;
  for (const LoopTerm& loop : window.loops) {
    q.push_back(loop.dof == 0 ? 0.0 : loop_chi2(window, loop) / loop_chi2_gate(loop.dof));
  }
  return q;
}

// Gives each loop the weight of its q. @return the largest change.
template <class Weight>
double reweight(Window& window, const Weight& weight) {
  const std::vector<double> q = fractions(window);
  double change = 0.0;
  for (std::size_t k = 0; k < q.size(); ++k) {
    const double w = weight(q[k]);
    change = std::max(change, std::abs(w - window.loops[k].weight));
    window.loops[k].weight = w;
  }
  return change;
}

SolveReport solve_gnc(Window& window, const GraphSettings& settings, NormalEquations& equations,
                      StopFlag stop) {
  SolveReport report;
  const std::vector<double> q = fractions(window);
  std::optional<double> mu = gnc_first_mu(*std::max_element(q.begin(), q.end()));
  for (int round = 0; mu && round < settings.guard_rounds && !stop.raised(); ++round) {
    reweight(window, [&](double fraction) { return gnc_weight(fraction, *mu); });
    equations.relinearise(window, settings.huber_sd);
    add(levenberg_marquardt(window, equations, settings, stop, settings.guard_iterations), report);
    const bool decided = std::all_of(window.loops.begin(), window.loops.end(), [](const auto& l) {
      return l.weight == 0.0 || l.weight == 1.0;
    });
    if (decided) break;
    *mu *= settings.gnc_factor;
  }
  // Weights still between 0 and 1 after so many rounds belong to loops at the gate.
  reweight(window, [](double fraction) { return fraction <= 1.0 ? 1.0 : 0.0; });
  return report;
}

// Alternates between weights and fit until they agree.
SolveReport solve_reweighted(Window& window, const GraphSettings& settings,
                             NormalEquations& equations, StopFlag stop) {
  SolveReport report;
  const auto weight = [&](double q) {
    if (settings.guard == LoopGuard::kHuber) return geometry::huber_weight(std::sqrt(q), 1.0);
    const double s = std::min(1.0, 2.0 / (1.0 + q));  // Agarwal et al. 2013, phi at the gate
    return s * s;
  };
  for (int round = 0; round < settings.guard_rounds && !stop.raised(); ++round) {
    if (reweight(window, weight) < kWeightChangeMin) break;
    equations.relinearise(window, settings.huber_sd);
    add(levenberg_marquardt(window, equations, settings, stop, settings.guard_iterations), report);
  }
  return report;
}

void set_weights(Window& window, double weight) {
  for (LoopTerm& loop : window.loops) loop.weight = weight;
}

}  // namespace

double loop_chi2_gate(int dof) {
  return quantile({0.0, 6.635, 9.210, 11.345, 13.277, 15.086, 16.812}, dof);
}

double loop_chi2_veto(int dof) {
  return quantile({0.0, 10.828, 13.816, 16.266, 18.467, 20.515, 22.458}, dof);
}

double gnc_weight(double q, double mu) {
  if (q <= mu / (mu + 1.0)) return 1.0;
  if (q >= (mu + 1.0) / mu) return 0.0;
  return std::sqrt(mu * (mu + 1.0) / q) - mu;
}

std::optional<double> gnc_first_mu(double q_max) {
  if (q_max <= 1.0) return std::nullopt;
  return 1.0 / (2.0 * q_max - 1.0);
}

double loop_chi2(const Window& window, const LoopTerm& loop) {
  LinearFactor factor;
  linearise(window, loop.term, factor);
  return factor.r.squaredNorm();
}

SolveReport solve_with_guard(Window& window, const GraphSettings& settings, StopFlag stop) {
  const bool any = !window.loops.empty();
  const bool reweighted = settings.guard == LoopGuard::kHuber || settings.guard == LoopGuard::kDcs;
  // The robust losses need a start without the effect of wrong loops; gnc begins with all (8.4).
  set_weights(window, reweighted ? 0.0 : 1.0);
  SolveReport report;
  report.cost_before = total_cost(window, settings.huber_sd);
  report.rotation_first = start_if_poor(window, settings);
  NormalEquations equations(window, settings.huber_sd);
  add(levenberg_marquardt(window, equations, settings, stop, settings.iterations), report);
  if (!any || settings.guard == LoopGuard::kNone) return report;
  add(reweighted ? solve_reweighted(window, settings, equations, stop)
                 : solve_gnc(window, settings, equations, stop),
      report);
  equations.relinearise(window, settings.huber_sd);
  add(levenberg_marquardt(window, equations, settings, stop, settings.iterations), report);
  return report;
}

}  // namespace rali::graph
