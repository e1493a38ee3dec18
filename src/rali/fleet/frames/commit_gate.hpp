#pragma once

#include "rali/base/time.hpp"
#include "rali/fleet/frames/decided_by.hpp"
#include "rali/fleet/frames/observability.hpp"

namespace rali::fleet {

/// One evaluation (algorithms_fleet 7.4, steps 4 and 5).
struct Decision {
  bool ready = false;
  DecidedBy by = DecidedBy::kRanges;  ///< kPrior: without the prior nothing would be decided
  Advice advice = Advice::kNoContact;
  double gap_chi2 = 0.0;  ///< of the second; infinite if there is none
  double odds = 0.0;      ///< of the second relative to the best
  double fit = 0.0;       ///< chi2 per degree of freedom of the best
  /// The user's start pose decides: no further evaluation is required.
  bool at_once = false;
  std::size_t chosen = 0;  ///< which hypothesis is committed
};

/// Whether the residuals agree with their sigmas: chi2/dof within [fit_min, fit_max]. With fewer
/// than 12 degrees of freedom the interval is widened, because chance alone leaves it. Sigmas that
/// are too large are safe, they only reduce every gap: so fit_min is 0 unless a user wants this
/// report.
[[nodiscard]] bool fit_is_plausible(double fit_chi2, int dof, const CommitSettings& settings);

/// @param keyframes of the local map that counts: the smaller one; preset paper: the larger one
[[nodiscard]] Decision decide(const HypothesisSet& set, const Observability& seen, int keyframes,
                              const InitSettings& settings);

/// Permits a commit after `evaluations` that agree, each ready and `spacing_s` after the previous
/// one. An evaluation that is not ready, or that prefers another pose, restarts the count.
class CommitGate {
 public:
  explicit CommitGate(const InitSettings& settings) : settings_(settings) {}

  /// @return true if the best hypothesis may be committed now
  bool evaluate(Time t, const Decision& decision, const FrameHypothesis* best);

  [[nodiscard]] int agreed() const { return agreed_; }

  void reset() { agreed_ = 0; }

 private:
  InitSettings settings_;
  int agreed_ = 0;
  Time t_last_;
  YawPose last_T_b_a_;
};

}  // namespace rali::fleet
