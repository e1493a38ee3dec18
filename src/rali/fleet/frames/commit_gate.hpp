#pragma once

#include <optional>
#include <string_view>

#include "rali/base/time.hpp"
#include "rali/fleet/frames/observability.hpp"

namespace rali::fleet {

/// A scan of one vehicle compared with the map of the other, at the best hypothesis.
struct ScanCheck {
  bool expected = true;  ///< false: walls stand between them, nothing can overlap
  double overlap = 0.0;  ///< share of points with a partner
  double median_m = 0.0;
  double voxel_noise_m = 0.0;
};

/// What a decision needs besides hypotheses.
struct CommitInputs {
  int keyframes = 0;               ///< of the smaller of the local maps
  std::optional<ScanCheck> check;  ///< nothing: nobody has compared scans
};

/// What a frame is known by.
enum class DecidedBy { kRanges, kScans, kRangesAndScans, kPrior };

/// As told to the user: "ranges and scans".
[[nodiscard]] std::string_view decided_by_text(DecidedBy by);

/// One evaluation (algorithms_fleet 7.4, steps 4 and 5).
struct Decision {
  bool ready = false;
  DecidedBy by = DecidedBy::kRanges;  ///< kPrior: without it nothing would be decided
  Advice advice = Advice::kNoContact;
  double gap_chi2 = 0.0;  ///< of the second; infinite if there is none
  double odds = 0.0;      ///< of the second against the best
  double fit = 0.0;       ///< chi2 per degree of freedom of the best
  /// The user's start pose decides: no second opinion is waited for.
  bool at_once = false;
  std::size_t chosen = 0;  ///< which hypothesis is committed
};

/// Whether the fit is as good as its sigmas say: chi2/dof within [fit_min, fit_max]. With fewer
/// than 12 degrees of freedom chance alone leaves that interval, so it widens. Sigmas that are too
/// large are safe, they only make every gap smaller: fit_min is 0 unless somebody wants to be told.
[[nodiscard]] bool fit_is_plausible(double fit_chi2, int dof, const CommitSettings& settings);

[[nodiscard]] Decision decide(const HypothesisSet& set, const Observability& seen,
                              const CommitInputs& inputs, const InitSettings& settings);

/// Lets a frame be committed after `evaluations` that agree, each ready and `spacing_s` after the
/// one before. One that is not ready, or that prefers another place, starts the count anew.
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

/// Watches a committed frame (7.4, step 7): the mean squared innovation of ranges over windows, and
/// how often scans do not fit.
class Watch {
 public:
  explicit Watch(const WatchSettings& settings) : settings_(settings) {}

  /// @param nis squared innovation over its variance. @return true if the frame must be undone
  bool add_range(double nis);

  /// A scan against the map. @return true if the frame must be undone
  bool add_scan(bool fits);

  void reset();

 private:
  WatchSettings settings_;
  double sum_ = 0.0;
  int count_ = 0;
  int bad_windows_ = 0;
  int refused_ = 0;
};

}  // namespace rali::fleet
