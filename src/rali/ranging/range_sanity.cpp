#include "rali/ranging/range_sanity.hpp"

#include <cmath>

namespace rali::ranging {

RangeSanity::RangeSanity(const RangeLimits& limits, const SanitySettings& settings)
    : limits_(limits), settings_(settings) {}

std::optional<RangeReason> RangeSanity::check(Time t, double range_m, double sigma_m,
                                              double rate_mps) {
  if (!(range_m >= limits_.near_m && range_m <= limits_.far_m)) return RangeReason::kOutOfLimits;
  const Point now{t, range_m};
  // Both checks need every range, whatever the other one returns.
  const bool frozen = is_frozen(now, rate_mps);
  const bool jump = is_jump(now, sigma_m);
  if (frozen || jump) return RangeReason::kOutlier;
  return std::nullopt;
}

bool RangeSanity::agrees(const Point& a, const Point& b, double sigma_m) const {
  // Late ranges arrive out of order: the change has no direction in time.
  const double dt_s = std::abs(seconds_between(a.t, b.t));
  const double max_m =
      (limits_.speed_max_mps + settings_.speed_margin_mps) * dt_s + settings_.jump_sigmas * sigma_m;
  return std::abs(b.range_m - a.range_m) <= max_m;
}

bool RangeSanity::is_jump(const Point& now, double sigma_m) {
  if (!sane_ || agrees(*sane_, now, sigma_m)) {
    sane_ = now;
    rejected_count_ = 0;
    return false;
  }
  const bool same_story = rejected_count_ > 0 && agrees(*rejected_, now, sigma_m);
  rejected_count_ = same_story ? rejected_count_ + 1 : 1;
  rejected_ = now;
  if (rejected_count_ < settings_.resync_count) return true;
  sane_ = now;
  rejected_count_ = 0;
  return false;
}

bool RangeSanity::is_frozen(const Point& now, double rate_mps) {
  // Exactly equal: radios report millimetres, and their noise is some centimetres.
  if (!repeated_ || repeated_->range_m != now.range_m) {
    repeats_ = 1;
    should_have_moved_m_ = 0.0;
  } else {
    ++repeats_;
    const double dt_s = std::abs(seconds_between(repeated_->t, now.t));
    if (std::isfinite(rate_mps)) should_have_moved_m_ += std::abs(rate_mps) * dt_s;
  }
  repeated_ = now;
  return repeats_ >= settings_.frozen_count && should_have_moved_m_ > settings_.frozen_moved_m;
}

}  // namespace rali::ranging
