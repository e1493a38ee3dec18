#pragma once

#include <optional>

#include "rali/base/time.hpp"
#include "rali/ranging/settings.hpp"

namespace rali::ranging {

/// How much a range may still count, given those of the same pair of antennas already used.
///
/// The error of a range is white noise plus a part that wanders (sd `slow_sigma_m`, correlation
/// exp(-dt / slow_time_s)). An estimator that takes errors as independent must not believe 20
/// ranges a second: what they have in common does not average out. So each range gets the variance
/// with which independent errors would add up to the same information about the distance.
///
/// Derivation: whiten the error by the Kalman filter of its slow part s. With a = exp(-dt/tau),
/// M = a^2 P + q (1 - a^2), S = M + r, K = M / S, the innovation reacts to the sought distance by
/// c = 1 - a m, where m is how far the estimate of s follows it: m <- a m + K c, P <- (1 - K) M.
/// Information adds up as c^2 / S, hence R = S / c^2. Its limits: the first range has R = r + q;
/// n ranges within the correlation time have together q + r / n, never less than q; at a steady
/// rate f the inflation tends to 1 + 2 tau f q / (r + q).
///
/// At rest multipath does not change, so time brings nothing new (a = 1): n ranges have q + r / n
/// however long they take. A vehicle that stands learns no more from more ranges.
///
/// For an estimator that follows motion with gain k [1/s] the result is safe but not tight: its
/// normalised squared error tends to (1 + 1 / (1 + k tau)) / 2, between 1 (slow) and 1/2 (fast).
class RangeThinning {
 public:
  explicit RangeThinning(const SlowErrorSettings& settings);

  /// The factor (at least 1) on the variance of this range, which counts as used from now on.
  /// `sigma_m`: of the whole error in line of sight; `at_rest`: neither end has moved since the
  /// last range that was used.
  [[nodiscard]] double inflation(Time t, double sigma_m, bool at_rest);

 private:
  SlowErrorSettings settings_;
  std::optional<Time> last_;
  double slow_variance_m2_ = 0.0;  ///< P: of the slow part, given the ranges so far
  double follows_ = 0.0;           ///< m: how its estimate reacts to the sought distance
};

}  // namespace rali::ranging
