#include "rali/ranging/range_link.hpp"

#include <algorithm>
#include <cmath>

namespace rali::ranging {
namespace {

/// Why a range is not used: an obstacle by signal or map, else the gate. One that passes the gate
/// of a suspect link contradicts its neighbours.
RangeReason reason_of(bool inside, bool clear) {
  if (!clear) return RangeReason::kNlos;
  return inside ? RangeReason::kOutlier : RangeReason::kBlockedByGate;
}

}  // namespace

RangeLink::RangeLink(const GateSettings& gate, const LinkSettings& settings)
    : gate_(gate), settings_(settings) {}

LinkState RangeLink::state(Time now) const {
  if (last_ && seconds_between(*last_, now) > settings_.lost_s) return LinkState::kLost;
  return state_;
}

LinkDecision RangeLink::decide(const LinkSample& sample) {
  LinkDecision out;
  out.gate = gate(sample.nu_m, sample.S_m2, sample.sigma_m, sample.clear, gate_);
  if (!std::isfinite(sample.nu_m) || !(sample.S_m2 > 0.0) || !std::isfinite(sample.S_m2) ||
      !(sample.sigma_m > 0.0)) {
    out.reason = RangeReason::kOutOfLimits;
    out.state = state_;
    return out;
  }
  remember(sample, out.gate.inside);
  if (state_ == LinkState::kGood && mostly_rejected()) {
    enter(LinkState::kSuspect);
    t_suspect_ = sample.t;
  }
  if (state_ == LinkState::kSuspect) {
    if (inside_in_row_ >= settings_.reacquire_count) {
      enter(LinkState::kGood);
    } else if (miss_by_one_offset(sample.t)) {
      out.advice = advise();
      if (out.advice == LinkAdvice::kWeAreWrong) out.widen_factor = settings_.widen_factor;
    }
  }
  out.state = state_;
  out.use = out.gate.inside && state_ == LinkState::kGood;
  out.reason = out.use ? RangeReason::kUsed : reason_of(out.gate.inside, sample.clear);
  return out;
}

void RangeLink::remember(const LinkSample& sample, bool inside) {
  if (state(sample.t) == LinkState::kLost) {
    // Old ranges do not predict the next one.
    window_.clear();
    inside_in_row_ = 0;
  }
  last_ = last_ ? std::max(*last_, sample.t) : sample.t;
  window_.push_back({sample.nu_m, sample.sigma_m, inside, sample.clear});
  if (window_.size() > static_cast<std::size_t>(settings_.window)) window_.pop_front();
  inside_in_row_ = inside ? inside_in_row_ + 1 : 0;
}

void RangeLink::enter(LinkState state) {
  state_ = state;
  inside_in_row_ = 0;
  if (state != LinkState::kGood) return;
  // Rejections before that must not count against the link again.
  window_.clear();
  widened_ = 0;
  alarmed_ = false;
}

bool RangeLink::mostly_rejected() const {
  if (window_.size() < static_cast<std::size_t>(settings_.window)) return false;
  const auto rejected =
      std::count_if(window_.begin(), window_.end(), [](const Seen& seen) { return !seen.inside; });
  return static_cast<double>(rejected) > settings_.suspect_fraction * settings_.window;
}

/// Ranges that are all too short mean that the pose is wrong: no obstacle shortens a range. Ranges
/// that are too long may come from an obstacle, unless they last.
bool RangeLink::miss_by_one_offset(Time now) const {
  if (!mostly_rejected()) return false;
  const double n = static_cast<double>(window_.size());
  double mean_m = 0.0;
  double sigma_m = 0.0;
  for (const Seen& seen : window_) {
    if (!seen.clear) return false;
    mean_m += seen.nu_m / n;
    sigma_m += seen.sigma_m / n;
  }
  if (mean_m > 0.0 && seconds_between(t_suspect_, now) < settings_.longer_s) return false;
  double variance_m2 = 0.0;
  for (const Seen& seen : window_) variance_m2 += (seen.nu_m - mean_m) * (seen.nu_m - mean_m) / n;
  return std::sqrt(variance_m2) < settings_.offset_sigmas * sigma_m;
}

LinkAdvice RangeLink::advise() {
  // Each attempt gets a full window of its own to show whether it helped.
  window_.clear();
  if (widened_ < settings_.widen_max) {
    ++widened_;
    return LinkAdvice::kWeAreWrong;
  }
  if (alarmed_) return LinkAdvice::kNone;
  alarmed_ = true;
  return LinkAdvice::kAlarm;
}

}  // namespace rali::ranging
