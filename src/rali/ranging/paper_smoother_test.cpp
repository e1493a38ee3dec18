#include "rali/ranging/paper_smoother.hpp"

#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::ranging {
namespace {

Time at(double t_s) { return Time::from_s(500.0 + t_s); }

PaperRangeSettings with(PaperSmoother smoother, double length_s = 1.0) {
  PaperRangeSettings s;
  s.smoother = smoother;
  s.smoother_s = length_s;
  return s;
}

/// The last of n ranges, `step_s` apart, of which the last one is at t = 0.
SmoothedRange last_of(PaperRangeSmoother& smoother, int n, double step_s,
                      const std::function<double(double)>& range_m) {
  std::optional<SmoothedRange> out;
  for (int i = 1 - n; i <= 0; ++i) out = smoother.add(at(step_s * i), range_m(step_s * i));
  return *out;
}

// Test T8 of the design: weights (-0.2, 0, 0.2, 0.4, 0.6).
TEST(PaperSmoother, a_line_fit_of_five_samples_matches_hand_computed_values) {
  PaperRangeSmoother smoother(with(PaperSmoother::kLine));
  const double u[] = {10.0, 10.1, 10.25, 10.28, 10.42};
  std::optional<SmoothedRange> out;
  for (int i = 0; i < 5; ++i) out = smoother.add(at(0.2 * i), u[i]);
  ASSERT_TRUE(out);
  EXPECT_NEAR(out->range_m, 10.414, 1e-9);
  EXPECT_NEAR(out->variance_m2, 0.6 * 0.01, 1e-12);
  EXPECT_EQ(out->samples, 5);
}

TEST(PaperSmoother, line_fit_weights_match_the_closed_form) {
  for (int unit = 0; unit < 5; ++unit) {
    PaperRangeSettings s = with(PaperSmoother::kLine);
    s.smoother_outlier_samples = 1000;  // one sample different from all others is meant here
    PaperRangeSmoother smoother(s);
    const double w[] = {-0.2, 0.0, 0.2, 0.4, 0.6};
    const auto out = last_of(
        smoother, 5, 0.1, [&](double t) { return std::lround(t / 0.1) + 4 == unit ? 11.0 : 10.0; });
    EXPECT_NEAR(out.range_m, 10.0 + w[unit], 1e-9) << unit;
  }
}

TEST(PaperSmoother, line_fit_over_21_samples_has_the_designed_sigma_and_bias) {
  PaperRangeSmoother smoother(with(PaperSmoother::kLine));
  const double acceleration = 0.5;
  const auto out =
      last_of(smoother, 60, 0.05, [&](double t) { return 20.0 + t + 0.5 * acceleration * t * t; });
  EXPECT_EQ(out.samples, 21);
  EXPECT_NEAR(std::sqrt(out.variance_m2) / 0.1, 0.4213, 1e-4);
  EXPECT_NEAR(out.range_m - 20.0, -0.079167 * acceleration, 1e-6);
}

TEST(PaperSmoother, consecutive_line_fits_have_a_correlation_of_0_883) {
  PaperRangeSettings s = with(PaperSmoother::kLine);
  s.smoother_outlier_sds = 100.0;
  PaperRangeSmoother smoother(s);
  Rng rng(7, "smoother");
  double xy = 0.0;
  double xx = 0.0;
  double before = 0.0;
  for (int i = 0; i < 15000; ++i) {
    const double x = smoother.add(at(0.05 * i), 10.0 + 0.1 * rng.normal())->range_m - 10.0;
    if (i > 21) {
      xy += x * before;
      xx += x * x;
    }
    before = x;
  }
  EXPECT_NEAR(xy / xx, 0.883, 0.01);
}

TEST(PaperSmoother, a_line_fit_is_exact_for_irregular_times) {
  PaperRangeSmoother smoother(with(PaperSmoother::kLine));
  Rng rng(1, "times");
  double t_s = 0.0;
  for (int i = 0; i < 200; ++i) {
    t_s += rng.uniform(0.001, 0.2);
    EXPECT_NEAR(smoother.add(at(t_s), 30.0 - 1.5 * t_s + 300.0)->range_m, 330.0 - 1.5 * t_s, 1e-9);
  }
}

TEST(PaperSmoother, each_mode_is_exact_for_curves_of_its_order) {
  const auto curve = [](double t) { return 20.0 + t + 0.25 * t * t; };
  PaperRangeSmoother quadratic(with(PaperSmoother::kQuadratic));
  EXPECT_NEAR(last_of(quadratic, 40, 0.05, curve).range_m, 20.0, 1e-9);
  PaperRangeSmoother mean(with(PaperSmoother::kMean));
  const SmoothedRange lagging = last_of(mean, 40, 0.05, [](double t) { return 20.0 + t; });
  EXPECT_NEAR(lagging.range_m, 19.5, 1e-9);  // v T / 2 behind
  EXPECT_NEAR(lagging.variance_m2, 0.01 / 21.0, 1e-12);
  PaperRangeSmoother none(with(PaperSmoother::kNone));
  const SmoothedRange raw = last_of(none, 40, 0.05, curve);
  EXPECT_EQ(raw.range_m, 20.0);
  EXPECT_NEAR(raw.variance_m2, 0.01, 1e-15);
  EXPECT_EQ(raw.samples, 1);
}

TEST(PaperSmoother, one_gross_error_is_removed_even_as_the_newest) {
  for (const int wrong : {0, -10, -19}) {
    PaperRangeSmoother smoother(with(PaperSmoother::kLine));
    Rng rng(2, "gross");
    const auto out = last_of(smoother, 21, 0.05, [&](double t) {
      return 20.0 + t + 0.02 * rng.normal() + (std::lround(t / 0.05) == wrong ? 3.0 : 0.0);
    });
    EXPECT_EQ(out.samples, 20) << wrong;
    EXPECT_NEAR(out.range_m, 20.0, 0.03) << wrong;
  }
}

TEST(PaperSmoother, restarts_after_a_gap_or_backward_time) {
  PaperRangeSmoother smoother(with(PaperSmoother::kLine));
  for (int i = 0; i < 10; ++i) (void)smoother.add(at(0.05 * i), 10.0);
  EXPECT_EQ(smoother.add(at(0.45 + 0.49), 10.0)->samples, 11);
  EXPECT_EQ(smoother.add(at(0.94 + 0.51), 15.0)->samples, 1);
  EXPECT_EQ(smoother.add(at(1.50), 15.0)->samples, 2);
  EXPECT_EQ(smoother.add(at(1.40), 15.0)->samples, 1);
}

TEST(PaperSmoother, restarts_after_a_reset_for_another_anchor) {
  PaperRangeSmoother smoother(with(PaperSmoother::kLine));
  for (int i = 0; i < 10; ++i) (void)smoother.add(at(0.05 * i), 10.0);
  smoother.reset();
  const auto out = smoother.add(at(0.5), 40.0);
  EXPECT_EQ(out->range_m, 40.0);
  EXPECT_NEAR(out->variance_m2, 0.01, 1e-15);
}

TEST(PaperSmoother, averages_samples_of_equal_time_without_division_by_zero) {
  for (const PaperSmoother mode : {PaperSmoother::kLine, PaperSmoother::kQuadratic}) {
    PaperRangeSmoother smoother(with(mode));
    (void)smoother.add(at(0.0), 10.0);
    const auto out = smoother.add(at(0.0), 10.2);
    EXPECT_NEAR(out->range_m, 10.1, 1e-9);
    EXPECT_NEAR(out->variance_m2, 0.005, 1e-12);
  }
}

TEST(PaperSmoother, skips_nan_ranges) {
  PaperRangeSmoother smoother(with(PaperSmoother::kLine));
  EXPECT_FALSE(smoother.add(at(0.0), std::nan("")));
  EXPECT_EQ(smoother.add(at(0.1), 10.0)->samples, 1);
}

TEST(PaperSmoother, a_flood_of_ranges_does_not_accumulate_samples) {
  PaperRangeSettings s = with(PaperSmoother::kNone);
  PaperRangeSmoother smoother(s);
  for (int i = 0; i < 20000; ++i) (void)smoother.add(at(0.0), 10.0);
  EXPECT_EQ(smoother.add(at(0.0), 10.0)->samples, 1);
}

}  // namespace
}  // namespace rali::ranging
