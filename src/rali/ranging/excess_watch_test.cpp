#include "rali/ranging/excess_watch.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::ranging {
namespace {

constexpr double kSigma = 0.1;

/// Residuals of one pair at 20 Hz.
struct Fed {
  ExcessWatch watch{ExcessSettings{}};
  double t_s = 100.0;
  double pose_sigma_m = 0.0;
  double turn_sigma_m = 0.0;
  int count = 0;

  ExcessVerdict next(double nu_m) {
    t_s += 0.05;
    ++count;
    return watch.look(Time::from_s(t_s), nu_m, kSigma, pose_sigma_m, turn_sigma_m);
  }

  /// Around `level_m`, 2 cm up and down: changes of 4 cm are a noise of 4.2 cm, 4 sds of it are
  /// 0.168 m, so that the least step of 0.2 m is the limit.
  ExcessVerdict quiet(double level_m) { return next(level_m + (count % 2 == 0 ? 0.02 : -0.02)); }

  void expect_quiet(int n, double level_m) {
    for (int k = 0; k < n; ++k) EXPECT_EQ(quiet(level_m), ExcessVerdict::kNone) << k;
  }
};

TEST(ExcessWatch, refuses_a_two_second_burst_from_its_first_range) {
  Fed fed;
  fed.expect_quiet(40, 0.0);
  EXPECT_EQ(fed.quiet(0.6), ExcessVerdict::kWaiting);
  EXPECT_EQ(fed.quiet(0.6), ExcessVerdict::kWaiting);
  for (int k = 2; k < 40; ++k) EXPECT_EQ(fed.quiet(0.6), ExcessVerdict::kExcess) << k;
  EXPECT_NEAR(fed.watch.step_m(), 0.6, 0.041);
  // Down again: accepted when three in a row agree.
  EXPECT_EQ(fed.quiet(0.0), ExcessVerdict::kExcess);
  EXPECT_EQ(fed.quiet(0.0), ExcessVerdict::kExcess);
  fed.expect_quiet(60, 0.0);
}

TEST(ExcessWatch, refuses_a_second_burst_like_the_first) {
  Fed fed;
  fed.expect_quiet(40, 0.0);
  for (int k = 0; k < 20; ++k) EXPECT_NE(fed.quiet(0.6), ExcessVerdict::kNone) << k;
  fed.quiet(0.0);
  fed.quiet(0.0);
  fed.expect_quiet(10, 0.0);
  for (int k = 0; k < 20; ++k) EXPECT_NE(fed.quiet(0.5), ExcessVerdict::kNone) << k;
}

TEST(ExcessWatch, holds_back_a_single_outlier_and_nothing_else) {
  Fed fed;
  fed.expect_quiet(40, 0.0);
  EXPECT_EQ(fed.next(0.6), ExcessVerdict::kWaiting);
  fed.expect_quiet(5, 0.0);
  EXPECT_EQ(fed.next(-0.6), ExcessVerdict::kWaiting);
  fed.expect_quiet(5, 0.0);
}

TEST(ExcessWatch, alternating_outliers_are_not_a_step) {
  Fed fed;
  fed.expect_quiet(40, 0.0);
  for (int k = 0; k < 10; ++k) {
    EXPECT_EQ(fed.next(k % 2 == 0 ? 0.6 : -0.6), ExcessVerdict::kWaiting) << k;
  }
  fed.expect_quiet(5, 0.0);
}

TEST(ExcessWatch, a_slowly_drifting_residual_is_not_a_step) {
  // 5 cm from one to the next, 1 m/s: five ranges behind, the median is off by more than 0.2 m.
  Fed fed;
  fed.expect_quiet(40, 0.0);
  for (int k = 0; k < 60; ++k) EXPECT_EQ(fed.quiet(0.05 * k), ExcessVerdict::kNone) << k;
}

TEST(ExcessWatch, reports_a_downward_step_as_relieved) {
  Fed fed;
  fed.expect_quiet(40, 0.0);
  EXPECT_EQ(fed.quiet(-0.5), ExcessVerdict::kWaiting);
  EXPECT_EQ(fed.quiet(-0.5), ExcessVerdict::kWaiting);
  EXPECT_EQ(fed.quiet(-0.5), ExcessVerdict::kRelieved);
  EXPECT_NEAR(fed.watch.step_m(), -0.5, 0.041);
  fed.expect_quiet(40, -0.5);
}

TEST(ExcessWatch, accepts_an_excess_that_lasts_longer_than_6_s) {
  Fed fed;
  fed.expect_quiet(40, 0.0);
  // The third range confirms the step; 6 s later, 120 ranges, it is accepted as distance.
  for (int k = 0; k < 123; ++k) EXPECT_NE(fed.quiet(0.6), ExcessVerdict::kNone) << k;
  fed.expect_quiet(40, 0.6);
  fed.quiet(0.0);
  fed.quiet(0.0);
  EXPECT_EQ(fed.quiet(0.0), ExcessVerdict::kRelieved);  // the line of sight is free again
}

TEST(ExcessWatch, allows_for_pose_sigma_when_the_line_of_sight_turns) {
  // The line of sight turned by 0.3 rad, the sigma of the pose is 0.5 m: 0.15 m, and 4 times that
  // is 0.6 m.
  Fed turned;
  turned.expect_quiet(40, 0.0);
  turned.turn_sigma_m = 0.15;
  turned.expect_quiet(10, 0.45);
  Fed straight;
  straight.expect_quiet(40, 0.0);
  EXPECT_EQ(straight.quiet(0.45), ExcessVerdict::kWaiting);
}

TEST(ExcessWatch, a_gap_of_1_1_s_ends_an_excess_and_step_detection) {
  Fed fed;
  fed.expect_quiet(40, 0.0);
  fed.t_s += 1.1;
  fed.expect_quiet(40, 0.6);  // meanwhile the pose may have drifted anywhere
  for (int k = 0; k < 10; ++k) EXPECT_NE(fed.quiet(1.2), ExcessVerdict::kNone) << k;
  fed.t_s += 1.1;
  fed.expect_quiet(20, 1.2);
  Fed shorter;
  shorter.expect_quiet(40, 0.0);
  shorter.t_s += 0.9;
  EXPECT_EQ(shorter.quiet(0.6), ExcessVerdict::kWaiting);
}

TEST(ExcessWatch, detects_no_step_before_a_reference_level_exists) {
  Fed fed;
  const double first_m[] = {0.0, 3.0, -2.0, 1.0, 0.5};
  for (const double nu_m : first_m) EXPECT_EQ(fed.next(nu_m), ExcessVerdict::kNone);
}

TEST(ExcessWatch, ignores_steps_below_4_sigma_of_the_range_noise) {
  // 10 cm up and down: the noise is sigma, 4 of them are 0.4 m. The same step is detected in ranges
  // with little noise.
  Fed noisy;
  for (int k = 0; k < 40; ++k) {
    EXPECT_EQ(noisy.next(k % 2 == 0 ? 0.1 : -0.1), ExcessVerdict::kNone) << k;
  }
  for (int k = 0; k < 4; ++k) EXPECT_EQ(noisy.next(0.25), ExcessVerdict::kNone) << k;
  Fed quiet;
  quiet.expect_quiet(40, 0.0);
  EXPECT_EQ(quiet.next(0.25), ExcessVerdict::kWaiting);
}

TEST(ExcessWatch, limits_the_estimated_noise_to_the_range_sigma) {
  Fed fed;
  for (int k = 0; k < 60; ++k) static_cast<void>(fed.next(k % 2 == 0 ? 0.3 : -0.3));
  EXPECT_EQ(fed.next(1.0), ExcessVerdict::kWaiting);  // by its own noise the limit would be 1.8 m
}

TEST(ExcessWatch, an_excess_ends_with_a_downward_step_over_40_percent) {
  // Of 1 m, 0.44 m are gone at once: more than 40 %. A step down of 0.3 m does not end it.
  Fed over;
  over.expect_quiet(40, 0.0);
  for (int k = 0; k < 20; ++k) static_cast<void>(over.next(1.0));
  static_cast<void>(over.next(0.56));
  static_cast<void>(over.next(0.56));
  EXPECT_EQ(over.next(0.56), ExcessVerdict::kNone);
  Fed not_yet;
  not_yet.expect_quiet(40, 0.0);
  for (int k = 0; k < 20; ++k) static_cast<void>(not_yet.next(1.0));
  for (int k = 0; k < 10; ++k) EXPECT_EQ(not_yet.next(0.7), ExcessVerdict::kExcess) << k;
}

TEST(ExcessWatch, an_excess_with_velocity_drift_still_ends_with_its_downward_step) {
  // The speed is wrong by 0.2 m/s: after 2 s the level is at 1.0 m, and the free distance at 0.4 m.
  Fed fed;
  fed.expect_quiet(40, 0.0);
  for (int k = 0; k < 40; ++k) EXPECT_NE(fed.next(0.6 + 0.01 * k), ExcessVerdict::kNone) << k;
  static_cast<void>(fed.next(0.41));
  static_cast<void>(fed.next(0.42));
  EXPECT_EQ(fed.next(0.43), ExcessVerdict::kNone);
}

TEST(ExcessWatch, an_excess_ends_if_pose_sigma_exceeds_it_1_5_times) {
  Fed fed;
  fed.expect_quiet(40, 0.0);
  for (int k = 0; k < 20; ++k) EXPECT_NE(fed.quiet(0.6), ExcessVerdict::kNone) << k;
  fed.pose_sigma_m = 1.0;  // more than 1.5 times 0.6 m
  EXPECT_EQ(fed.quiet(0.6), ExcessVerdict::kNone);
}

TEST(ExcessWatch, noise_alone_is_rarely_a_step) {
  Rng rng(7, "excess");
  Fed fed;
  int refused = 0;
  int steps = 0;
  for (int k = 0; k < 4000; ++k) {
    const ExcessVerdict verdict = fed.next(0.08 * rng.normal());
    refused += verdict != ExcessVerdict::kNone;
    steps += verdict == ExcessVerdict::kExcess || verdict == ExcessVerdict::kRelieved;
  }
  EXPECT_LT(refused, 8);
  EXPECT_EQ(steps, 0);
}

TEST(ExcessWatch, nan_and_infinite_residuals_change_nothing) {
  Fed fed;
  fed.expect_quiet(40, 0.0);
  for (int k = 0; k < 5; ++k) {
    EXPECT_EQ(fed.next(std::nan("")), ExcessVerdict::kNone);
    EXPECT_EQ(fed.next(std::numeric_limits<double>::infinity()), ExcessVerdict::kNone);
  }
  EXPECT_EQ(fed.quiet(0.6), ExcessVerdict::kWaiting);
}

TEST(ExcessWatch, a_reset_clears_its_level_and_excess) {
  Fed fed;
  fed.expect_quiet(40, 0.0);
  for (int k = 0; k < 10; ++k) static_cast<void>(fed.quiet(0.6));
  fed.watch.reset();
  fed.expect_quiet(20, 0.6);
}

}  // namespace
}  // namespace rali::ranging
