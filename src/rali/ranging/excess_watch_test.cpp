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
  double turn_sigma_m = 0.0;
  double speed_sigma_mps = 0.05;
  double pose_sigma_m = std::numeric_limits<double>::infinity();
  int count = 0;

  ExcessVerdict next(double nu_m) {
    t_s += 0.05;
    ++count;
    ExcessSample sample;
    sample.t = Time::from_s(t_s);
    sample.range_m = 10.0 + nu_m;
    sample.sigma_m = kSigma;
    sample.speed_sigma_mps = speed_sigma_mps;
    sample.residual_m = nu_m;
    sample.pose_sigma_m = pose_sigma_m;
    sample.turn_sigma_m = turn_sigma_m;
    return watch.look(sample);
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
  fed.expect_quiet(60, 0.0);
}

// Reflections: a step of four ranges that is no longer than the noise allows, and no step down.
TEST(ExcessWatch, a_few_long_ranges_do_not_shut_out_those_at_the_level_before) {
  Fed fed;
  fed.speed_sigma_mps = 0.03;
  fed.pose_sigma_m = 0.15;
  fed.expect_quiet(100, 0.0);
  for (const double nu_m : {0.45, 0.8, 0.25, 0.3, 0.25}) static_cast<void>(fed.next(nu_m));
  ASSERT_TRUE(fed.watch.in_excess());
  for (int k = 0; k < 20; ++k) static_cast<void>(fed.quiet(0.2 - 0.01 * k));  // sinks gradually
  for (int k = 0; k < 12; ++k) static_cast<void>(fed.quiet(0.0));
  fed.expect_quiet(40, 0.0);
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

TEST(ExcessWatch, a_drift_that_the_sigma_of_the_speed_explains_is_no_step) {
  // 1 cm from one to the next, 0.2 m/s: at most 4 sigma.
  Fed fed;
  fed.expect_quiet(40, 0.0);
  for (int k = 0; k < 60; ++k) EXPECT_EQ(fed.quiet(0.01 * k), ExcessVerdict::kNone) << k;
}

TEST(ExcessWatch, an_obstacle_that_comes_and_goes_gradually_is_an_excess) {
  // 1.5 m within 1.5 s, 5 cm from one to the next.
  Fed fed;
  fed.expect_quiet(100, 0.0);
  for (int k = 0; k < 30; ++k) static_cast<void>(fed.quiet(0.05 * k));
  for (int k = 0; k < 200; ++k) EXPECT_EQ(fed.quiet(1.5), ExcessVerdict::kExcess) << k;
  for (int k = 30; k > 0; --k) static_cast<void>(fed.quiet(0.05 * k));
  for (int k = 0; k < 60; ++k) static_cast<void>(fed.quiet(0.0));
  fed.expect_quiet(40, 0.0);
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

TEST(ExcessWatch, accepts_an_excess_that_lasts_longer_than_60_s) {
  Fed fed;
  fed.expect_quiet(40, 0.0);
  // The third range confirms the step; 60 s later, 1200 ranges, it is accepted as distance.
  for (int k = 0; k < 1200; ++k) EXPECT_NE(fed.quiet(0.6), ExcessVerdict::kNone) << k;
  for (int k = 0; k < 10; ++k) static_cast<void>(fed.quiet(0.6));
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

TEST(ExcessWatch, detects_a_step_over_a_gap_if_the_motion_meanwhile_does_not_explain_it) {
  Fed sure;
  sure.expect_quiet(40, 0.0);
  sure.t_s += 2.0;
  sure.speed_sigma_mps = 0.02;  // four sigma of 2.25 s are 0.18 m
  EXPECT_EQ(sure.quiet(0.6), ExcessVerdict::kWaiting);
  Fed unsure;
  unsure.expect_quiet(40, 0.0);
  unsure.t_s += 2.0;
  unsure.speed_sigma_mps = 0.1;  // 0.9 m
  unsure.expect_quiet(4, 0.6);
  Fed long_after;
  long_after.expect_quiet(40, 0.0);
  long_after.t_s += 10.1;
  long_after.expect_quiet(40, 0.6);
}

// A radio that was lost for 3 s behind a lorry: the pose had become uncertain meanwhile, so the
// ranges, still 1.4 m too long, moved it.
TEST(ExcessWatch, an_excess_outlasts_a_gap_until_ranges_step_down_or_fit_the_pose) {
  Fed fed;
  fed.speed_sigma_mps = 0.15;
  fed.expect_quiet(40, 0.0);
  for (int k = 0; k < 40; ++k) EXPECT_NE(fed.quiet(1.4), ExcessVerdict::kNone) << k;
  fed.t_s += 3.0;
  for (int k = 0; k < 40; ++k) EXPECT_EQ(fed.quiet(1.4), ExcessVerdict::kExcess) << k;
  Fed down = fed;
  for (int k = 0; k < 3; ++k) static_cast<void>(down.quiet(0.0));
  down.expect_quiet(20, 0.0);
  // It ended within the gap, in which 2 x 0.3 m/s x 3 s are no step. But it fits the pose.
  fed.t_s += 3.0;
  fed.speed_sigma_mps = 0.3;
  fed.pose_sigma_m = 0.3;
  for (int k = 0; k < 5; ++k) static_cast<void>(fed.quiet(0.8));
  EXPECT_TRUE(fed.watch.in_excess());
  for (int k = 0; k < 5; ++k) static_cast<void>(fed.quiet(0.5));
  EXPECT_FALSE(fed.watch.in_excess());
}

TEST(ExcessWatch, ranges_that_pass_between_obstructed_ones_are_used) {
  Fed fed;
  fed.expect_quiet(40, 0.0);
  for (int k = 0; k < 10; ++k) static_cast<void>(fed.quiet(0.8));
  for (int k = 0; k < 100; ++k) {
    const bool passes = k % 3 == 0;
    EXPECT_EQ(fed.quiet(passes ? 0.0 : 0.8), passes ? ExcessVerdict::kNone : ExcessVerdict::kExcess)
        << k;
  }
  fed.expect_quiet(40, 0.0);
  EXPECT_FALSE(fed.watch.in_excess());
}

// Reflections change between two vehicles at standstill: for minutes each range was compared with a
// level that no longer existed.
TEST(ExcessWatch, a_change_too_small_for_a_step_becomes_the_level) {
  Fed fed;
  fed.speed_sigma_mps = 0.0;
  fed.expect_quiet(40, 0.0);
  for (int k = 0; k < 40; ++k) EXPECT_NE(fed.quiet(0.15), ExcessVerdict::kExcess) << k;
  fed.expect_quiet(1000, 0.15);
  EXPECT_EQ(fed.quiet(0.28), ExcessVerdict::kNone) << "0.13 m above the new level";
}

TEST(ExcessWatch, detects_no_step_before_a_reference_level_exists) {
  Fed fed;
  const double first_m[] = {0.0, 3.0, -2.0, 1.0, 0.5};
  for (const double nu_m : first_m) EXPECT_EQ(fed.next(nu_m), ExcessVerdict::kNone);
}

TEST(ExcessWatch, ignores_steps_below_4_sigma_of_the_range_noise) {
  // 10 cm up and down: the noise is sigma, 4 of them are 0.4 m, of a median of several 0.3 m. A
  // range is as long in ranges with little noise, where it may be a step.
  Fed noisy;
  for (int k = 0; k < 40; ++k) {
    EXPECT_EQ(noisy.next(k % 2 == 0 ? 0.1 : -0.1), ExcessVerdict::kNone) << k;
  }
  for (int k = 0; k < 40; ++k) {
    EXPECT_EQ(noisy.next(k % 2 == 0 ? 0.25 : 0.05), ExcessVerdict::kNone) << k;
  }
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
