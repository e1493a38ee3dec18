#include "rali/ranging/range_thinning.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::ranging {
namespace {

constexpr double kWhite = 0.03;
constexpr double kSlow = 0.04;
constexpr double kTau = 3.0;
constexpr double kPeriod = 0.05;
const double kSigma = std::hypot(kWhite, kSlow);  // 5 cm, slow fraction 0.64

/// The numbers below are worked for these, whatever the defaults are.
SlowErrorSettings worked() {
  SlowErrorSettings settings;
  settings.slow_sigma_m = kSlow;
  settings.slow_time_s = kTau;
  return settings;
}

Time at(double t_s) { return Time::from_s(1000.0 + t_s); }

/// Variance of all ranges together if each counts with its inflated variance.
struct Sum {
  RangeThinning thinning{worked()};
  double information = 0.0;

  void add(double t_s, bool at_rest) {
    information += 1.0 / (thinning.inflation(at(t_s), kSigma, at_rest) * kSigma * kSigma);
  }

  [[nodiscard]] double variance_m2() const { return 1.0 / information; }
};

TEST(RangeThinning, does_not_inflate_the_first_range) {
  RangeThinning thinning{worked()};
  EXPECT_EQ(thinning.inflation(at(0.0), 0.1, false), 1.0);
}

// n ranges with one common error: q + r / n.
TEST(RangeThinning, ranges_at_standstill_average_only_their_white_noise) {
  Sum sum;
  for (int n = 1; n <= 1000; ++n) {
    sum.add(10.0 * n, true);  // time between them does not help
    if (n == 1 || n == 2 || n == 10 || n == 1000) {
      EXPECT_NEAR(sum.variance_m2(), kSlow * kSlow + kWhite * kWhite / n, 1e-9) << n;
    }
  }
}

TEST(RangeThinning, an_hour_at_standstill_does_not_reduce_the_common_error) {
  Sum sum;
  for (int n = 0; n < 72000; ++n) sum.add(kPeriod * n, true);  // an hour
  EXPECT_GE(std::sqrt(sum.variance_m2()), kSlow * 0.9999);
}

TEST(RangeThinning, ranges_within_the_correlation_time_count_as_one) {
  Sum sum;
  for (int n = 0; n < 10; ++n) sum.add(0.001 * n, false);
  EXPECT_NEAR(std::sqrt(sum.variance_m2()), std::hypot(kSlow, kWhite / std::sqrt(10.0)), 2e-4);
}

TEST(RangeThinning, at_a_steady_rate_converges_to_the_derived_inflation) {
  RangeThinning thinning{worked()};
  double inflation = 0.0;
  for (int n = 0; n < 2000; ++n) inflation = thinning.inflation(at(kPeriod * n), kSigma, false);
  // 1 + 2 tau f q / (r + q) = 1 + 120 x 0.64; exact (1 - fraction) + fraction (1 + a) / (1 - a)
  EXPECT_NEAR(inflation, 1.0 + 2.0 * kTau / kPeriod * 0.64, 1.0);
  const double a = std::exp(-kPeriod / kTau);
  EXPECT_NEAR(inflation, 0.36 + 0.64 * (1.0 + a) / (1.0 - a), 1e-6);
}

TEST(RangeThinning, ranges_far_apart_in_time_are_independent) {
  RangeThinning thinning{worked()};
  for (int n = 0; n < 5; ++n) {
    EXPECT_NEAR(thinning.inflation(at(60.0 * n), kSigma, false), 1.0, 1e-6) << n;
  }
}

TEST(RangeThinning, keeps_the_inflation_when_driving_on_after_a_standstill) {
  RangeThinning thinning{worked()};
  for (int n = 0; n < 400; ++n) (void)thinning.inflation(at(kPeriod * n), kSigma, true);
  EXPECT_GT(thinning.inflation(at(20.0), kSigma, false), 10.0);
}

TEST(RangeThinning, does_not_inflate_without_a_common_error) {
  SlowErrorSettings none;
  none.slow_sigma_m = 0.0;
  RangeThinning thinning{none};
  for (int n = 0; n < 100; ++n) {
    EXPECT_NEAR(thinning.inflation(at(kPeriod * n), 0.1, n % 2 == 0), 1.0, 1e-12);
  }
}

TEST(RangeThinning, stays_finite_for_repeated_times_and_invalid_sigmas) {
  RangeThinning thinning{worked()};
  for (const double sigma : {0.1, 0.001, 0.0, std::nan(""), 1e200, 0.1}) {
    for (int n = 0; n < 1000; ++n) {
      const double f = thinning.inflation(at(0.0), sigma, false);
      ASSERT_TRUE(f >= 1.0 && f <= 1e9) << sigma << " " << f;
    }
  }
}

/// A white and a slow error.
struct RangeError {
  Rng rng;
  double slow_m;

  explicit RangeError(std::uint64_t seed) : rng(seed, "thinning"), slow_m(kSlow * rng.normal()) {}

  double next(double dt_s) {
    const double a = std::exp(-dt_s / kTau);
    slow_m = a * slow_m + kSlow * std::sqrt(1.0 - a * a) * rng.normal();
    return slow_m + kWhite * rng.normal();
  }
};

/// Mean normalised squared error of a tracker of a random walk with `walk_m` per period.
double mean_nees(double walk_m, bool thinned) {
  constexpr int kRuns = 40;
  constexpr int kSteps = 1200;
  double sum = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    RangeError error(static_cast<std::uint64_t>(run));
    RangeThinning thinning{worked()};
    double truth = 0.0;
    double x = error.rng.normal();
    double P = 1.0;
    for (int i = 0; i < kSteps; ++i) {
      truth += walk_m * error.rng.normal();
      P += walk_m * walk_m;
      const double u = truth + error.next(kPeriod);
      const double f = thinned ? thinning.inflation(at(kPeriod * i), kSigma, false) : 1.0;
      const double gain = P / (P + f * kSigma * kSigma);
      x += gain * (u - x);
      P *= 1.0 - gain;
      sum += (x - truth) * (x - truth) / P;
    }
  }
  return sum / (kRuns * kSteps);
}

// The second figure is what happens without thinning: the test would not pass by chance.
TEST(RangeThinning, makes_a_slowly_drifting_tracker_consistent_by_nees) {
  const double honest = mean_nees(0.003, true);
  EXPECT_GT(honest, 0.7);
  EXPECT_LT(honest, 1.5);
  EXPECT_GT(mean_nees(0.003, false), 4.0);
}

TEST(RangeThinning, makes_a_faster_drifting_tracker_conservative_by_nees) {
  const double honest = mean_nees(0.01, true);
  EXPECT_GT(honest, 0.7);  // (1 + 1 / (1 + k tau)) / 2 with k tau = 1.37: 0.71
  EXPECT_LT(honest, 1.0);
}

}  // namespace
}  // namespace rali::ranging
