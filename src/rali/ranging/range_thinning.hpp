#pragma once

#include <optional>

#include "rali/base/time.hpp"
#include "rali/ranging/settings.hpp"

namespace rali::ranging {

/// Variance inflation of a range, given the ranges of the same pair of antennas already used.
///
/// The error of a range is white noise plus a slow part (sd `slow_sigma_m`, correlation
/// exp(-dt / slow_time_s)). The slow part does not average out: an estimator that assumes
/// independent errors would be overconfident with 20 ranges a second. So each range gets the
/// variance with which independent errors would add up to the same information about the distance.
///
/// Derivation: whiten the error by the Kalman filter of its slow part s. With a = exp(-dt/tau),
/// M = a^2 P + q (1 - a^2), S = M + r, K = M / S, the innovation responds to the unknown distance
/// by c = 1 - a m, where m is the response of the estimate of s: m <- a m + K c, P <- (1 - K) M.
/// Information adds up as c^2 / S, hence R = S / c^2. Its limits: the first range has R = r + q;
/// n ranges within the correlation time have together q + r / n, never less than q; at a steady
/// rate f the inflation tends to 1 + 2 tau f q / (r + q).
///
/// At standstill multipath does not change, so time adds no information (a = 1): n ranges have
/// q + r / n however long they take. More ranges do not reduce q.
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
  double follows_ = 0.0;           ///< m: response of its estimate to the unknown distance
};

}  // namespace rali::ranging
