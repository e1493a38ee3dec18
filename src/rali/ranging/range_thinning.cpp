#include "rali/ranging/range_thinning.hpp"

#include <algorithm>
#include <cmath>

namespace rali::ranging {
namespace {

/// Part of the noise is independent for every range: without it, the second range at one instant
/// would have no information at all and the quotients below no value.
constexpr double kMaxSlowFraction = 0.95;
/// Keeps the variance of a range without new information finite.
constexpr double kMaxInflation = 1e9;

}  // namespace

RangeThinning::RangeThinning(const SlowErrorSettings& settings) : settings_(settings) {}

double RangeThinning::inflation(Time t, double sigma_m, bool at_rest) {
  const double all_m2 = sigma_m * sigma_m;
  if (!(all_m2 > 0.0) || !std::isfinite(all_m2)) return kMaxInflation;
  const double slow_m2 =
      std::min(settings_.slow_sigma_m * settings_.slow_sigma_m, kMaxSlowFraction * all_m2);
  double a = 0.0;
  if (last_) {
    // A late range is as near to the last one as an early one.
    const double dt_s = std::abs(seconds_between(*last_, t));
    a = at_rest ? 1.0 : std::exp(-dt_s / settings_.slow_time_s);
  }
  last_ = last_ ? std::max(*last_, t) : t;
  const double predicted_m2 = a * a * slow_variance_m2_ + (1.0 - a * a) * slow_m2;
  const double S_m2 = predicted_m2 + all_m2 - slow_m2;
  const double gain = predicted_m2 / S_m2;
  const double c = 1.0 - a * follows_;
  follows_ = a * follows_ + gain * c;
  slow_variance_m2_ = (1.0 - gain) * predicted_m2;
  if (c * c * kMaxInflation * all_m2 <= S_m2) return kMaxInflation;
  return std::max(1.0, S_m2 / (c * c * all_m2));
}

}  // namespace rali::ranging
