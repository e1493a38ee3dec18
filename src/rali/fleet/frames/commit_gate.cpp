#include "rali/fleet/frames/commit_gate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Eigenvalues>

namespace rali::fleet {

namespace {

/// From this number of degrees of freedom on chi2/dof is tested by the settings alone.
constexpr double kFullDof = 12.0;

/// Whether the best would fail to win, or lack information, without the user's prior.
bool needs_prior(const HypothesisSet& set, const InitSettings& settings) {
  if (!set.has_prior) return false;
  const FrameHypothesis& best = set.all.front();
  const Mat4 without = best.drift_information - best.prior_information;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(
      scaled_planar_information(without, settings.commit), Eigen::EigenvaluesOnly);
  if (solver.eigenvalues()[0] < settings.commit.information_min) return true;
  const double own = best.chi2 - best.prior_chi2;
  return std::any_of(set.all.begin() + 1, set.all.end(), [&](const FrameHypothesis& h) {
    return (h.chi2 - h.prior_chi2 - own) / set.inflation() <= settings.commit.gap_chi2;
  });
}

DecidedBy origin(const HypothesisSet& set, const InitSettings& settings) {
  if (needs_prior(set, settings)) return DecidedBy::kPrior;
  if (!set.all.front().scans) return DecidedBy::kRanges;
  return set.ranges.empty() ? DecidedBy::kScans : DecidedBy::kRangesAndScans;
}

/// For scans alone: where places are alike, a wrong one may be recognised more than once, but then
/// with rivals.
bool seen_enough(const HypothesisSet& set, const CommitSettings& settings) {
  int against = 0;
  for (std::size_t k = 1; k < set.all.size(); ++k) against = std::max(against, set.all[k].views);
  return set.all.front().views >= settings.views_min + against;
}

/// Preset paper: decides by the size of the map, whatever the residuals are.
Decision decide_at_size(const HypothesisSet& set, int keyframes, const InitSettings& settings,
                        Decision d) {
  d.by = DecidedBy::kPrior;
  if (!set.has_prior) {
    d.advice = Advice::kNoPrior;
  } else if (keyframes < settings.commit.min_keyframes) {
    d.advice = Advice::kSmallMap;
  } else {
    d.advice = Advice::kEnough;
    d.ready = true;
  }
  return d;
}

/// The cheapest hypothesis that agrees with the user's start pose.
std::optional<std::size_t> with_prior(const HypothesisSet& set) {
  for (std::size_t k = 0; k < set.all.size(); ++k) {
    if (set.all[k].priors_denied == 0) return k;
  }
  return std::nullopt;
}

/// A measured start pose relates two vehicles within its sigmas; ranges and scans refine it. It is
/// overruled only by another hypothesis that is certain without it, or, if none is, by one that is
/// much better and fits. Ranges that fit nowhere contradict one another, not the start pose: behind
/// racks they are metres too long for a minute. So are those through the walls of a storey, and
/// these often fit another place: ranges too long for the start pose do not speak against it.
Decision decide_with_prior(const HypothesisSet& set, Decision d, const InitSettings& settings) {
  const std::optional<std::size_t> held = with_prior(set);
  if (!held) return d;
  // Whether another hypothesis is better: if it is certain, by the gap required between any two; if
  // not, by the largest chi2 of a wrong start pose.
  const double maximum = d.ready ? settings.commit.gap_chi2 : settings.prior.wrong_chi2;
  const FrameSolution& best = set.all.front().solution;
  const bool fits = fit_is_plausible(best.fit_chi2, best.dof, settings.commit);
  if (*held > 0 && (d.ready || fits) && set.gap_unobstructed(*held) > maximum) return d;
  if (!d.ready) d.by = DecidedBy::kPrior;
  d.ready = d.at_once = true;
  d.chosen = *held;
  d.advice = Advice::kEnough;
  return d;
}

}  // namespace

bool fit_is_plausible(double fit_chi2, int dof, const CommitSettings& settings) {
  if (dof <= 0) return fit_chi2 <= settings.gap_chi2;
  const double fit = fit_chi2 / dof;
  const double wider = std::sqrt(std::max(1.0, kFullDof / dof));
  const bool low = dof >= kFullDof && fit < settings.fit_min;
  return !low && fit < 1.0 + (settings.fit_max - 1.0) * wider;
}

namespace {

/// Decision by ranges and scans, with the user's start pose as one measurement among them.
Decision decide_by_all(const HypothesisSet& set, const Observability& seen, int keyframes,
                       const InitSettings& settings) {
  Decision d;
  d.advice = seen.advice;
  d.gap_chi2 = std::numeric_limits<double>::infinity();
  if (set.all.empty()) return d;
  const FrameHypothesis& best = set.all.front();
  if (set.all.size() > 1) d.gap_chi2 = set.gap(1);
  d.odds = std::exp(-0.5 * d.gap_chi2);
  d.fit = best.solution.dof > 0 ? best.solution.fit_chi2 / best.solution.dof : 0.0;
  d.by = origin(set, settings);
  if (d.advice != Advice::kEnough) return d;
  if (keyframes < settings.commit.min_keyframes) {
    d.advice = Advice::kSmallMap;
  } else if (!fit_is_plausible(best.solution.fit_chi2, best.solution.dof, settings.commit)) {
    d.advice = d.fit > 1.0 ? Advice::kMisfit : Advice::kTooGood;
  } else if (set.only_scans && !seen_enough(set, settings.commit)) {
    d.advice = Advice::kFewViews;
  } else {
    d.ready = d.gap_chi2 > settings.commit.gap_chi2;
  }
  return d;
}

}  // namespace

Decision decide(const HypothesisSet& set, const Observability& seen, int keyframes,
                const InitSettings& settings) {
  if (settings.commit.rule == CommitRule::kAtSize) {
    Decision d;
    d.advice = seen.advice;
    return set.all.empty() ? d : decide_at_size(set, keyframes, settings, d);
  }
  Decision d = decide_by_all(set, seen, keyframes, settings);
  return set.has_prior ? decide_with_prior(set, d, settings) : d;
}

bool CommitGate::evaluate(Time t, const Decision& decision, const FrameHypothesis* best) {
  if (!decision.ready || best == nullptr) {
    reset();
    return false;
  }
  if (settings_.commit.rule == CommitRule::kAtSize || decision.at_once) return true;
  const double moved_m = (last_T_b_a_ * best->pivot_a_m - best->place_b_m()).norm();
  const double turned_rad = std::abs(wrapped(last_T_b_a_.yaw_rad - best->T_b_a.yaw_rad));
  const SearchSettings& near = settings_.search;
  if (moved_m > near.merge_m || turned_rad > near.merge_deg * kDegree) agreed_ = 0;
  if (agreed_ > 0 && seconds_between(t_last_, t) < settings_.commit.spacing_s) return false;
  last_T_b_a_ = best->T_b_a;
  t_last_ = t;
  ++agreed_;
  return agreed_ >= settings_.commit.evaluations;
}

}  // namespace rali::fleet
