#include "rali/ranging/range_sanity.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::ranging {
namespace {

constexpr double kSigma = 0.1;
constexpr double kPeriod = 0.05;
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// One link at 20 Hz.
struct Link {
  RangeSanity sanity{RangeLimits{}, SanitySettings{}};
  double t_s = 100.0;

  std::optional<RangeReason> next(double range_m, double rate_mps = kUnknown) {
    t_s += kPeriod;
    return sanity.check(Time::from_s(t_s), range_m, kSigma, rate_mps);
  }
};

TEST(RangeSanity, refuses_ranges_below_0_3_m_above_300_m_or_nan) {
  Link link;
  for (const double u :
       {0.29, -5.0, 0.0, 300.1, 1e300, std::nan(""), std::numeric_limits<double>::infinity()}) {
    EXPECT_EQ(link.next(u), RangeReason::kOutOfLimits) << u;
  }
  EXPECT_EQ(link.next(0.3), std::nullopt);
}

// (6 + 1) m/s x 0.05 s + 4 x 0.1 m = 0.75 m
TEST(RangeSanity, limits_the_change_of_a_range_by_speed_and_noise) {
  Link link;
  EXPECT_EQ(link.next(20.0), std::nullopt);
  EXPECT_EQ(link.next(20.74), std::nullopt);
  EXPECT_EQ(link.next(20.74 - 0.76), RangeReason::kOutlier);
  EXPECT_EQ(link.next(20.74 + 0.1), std::nullopt);
}

TEST(RangeSanity, a_gross_error_does_not_become_the_reference) {
  Link link;
  EXPECT_EQ(link.next(20.0), std::nullopt);
  EXPECT_EQ(link.next(25.0), RangeReason::kOutlier);
  EXPECT_EQ(link.next(20.1), std::nullopt);
}

TEST(RangeSanity, replaces_a_wrong_reference_after_consistent_rejected_ranges) {
  Link link;
  EXPECT_EQ(link.next(25.0), std::nullopt);  // the very first one is the gross error
  for (int i = 0; i < 4; ++i) EXPECT_EQ(link.next(20.0 + 0.01 * i), RangeReason::kOutlier) << i;
  EXPECT_EQ(link.next(20.05), std::nullopt);
  EXPECT_EQ(link.next(20.06), std::nullopt);
}

TEST(RangeSanity, inconsistent_outliers_never_become_the_reference) {
  Link link;
  EXPECT_EQ(link.next(20.0), std::nullopt);
  for (int i = 0; i < 30; ++i) {
    EXPECT_EQ(link.next(i % 2 == 0 ? 200.0 : 290.0), RangeReason::kOutlier) << i;
  }
}

TEST(RangeSanity, accepts_any_valid_range_after_60_s_of_silence) {
  Link link;
  EXPECT_EQ(link.next(20.0), std::nullopt);
  link.t_s += 60.0;
  EXPECT_EQ(link.next(290.0), std::nullopt);
}

TEST(RangeSanity, compares_a_late_range_by_the_absolute_time_difference) {
  RangeSanity sanity{RangeLimits{}, SanitySettings{}};
  EXPECT_EQ(sanity.check(Time::from_s(10.0), 20.0, kSigma, kUnknown), std::nullopt);
  EXPECT_EQ(sanity.check(Time::from_s(9.0), 26.0, kSigma, kUnknown), std::nullopt);
}

TEST(RangeSanity, a_value_repeated_while_the_vehicle_drives_is_a_frozen_radio) {
  Link link;
  int refused = 0;
  for (int i = 0; i < 40; ++i) refused += link.next(20.0, 1.0).has_value();
  // At 1 m/s the range should have changed by more than 0.5 m after 11 periods.
  EXPECT_EQ(refused, 40 - 11);
  EXPECT_EQ(link.next(20.0, 0.0), RangeReason::kOutlier);
  EXPECT_EQ(link.next(20.001, 1.0), std::nullopt);
}

TEST(RangeSanity, a_value_repeated_at_rest_or_without_a_pose_is_no_fault) {
  Link at_rest;
  Link without_pose;
  for (int i = 0; i < 500; ++i) {
    EXPECT_EQ(at_rest.next(20.0, 0.0), std::nullopt);
    EXPECT_EQ(without_pose.next(20.0), std::nullopt);
  }
}

TEST(RangeSanity, accepts_noisy_ranges_of_a_vehicle_at_6_m_per_s) {
  Link link;
  Rng rng(5, "sanity");
  int refused = 0;
  double rho = 20.0;
  for (int i = 0; i < 2000; ++i) {
    const double rate = (i / 400) % 2 == 0 ? 6.0 : -6.0;
    rho += rate * kPeriod;
    refused += link.next(rho + kSigma * rng.normal(), rate).has_value();
  }
  // Difference of two ranges: sd 0.141 m; the limit is 0.45 m from the mean, 3.2 sd, one side.
  EXPECT_LE(refused, 8);
}

}  // namespace
}  // namespace rali::ranging
