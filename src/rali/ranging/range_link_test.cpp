#include "rali/ranging/range_link.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::ranging {
namespace {

constexpr double kSigma = 0.1;
constexpr double kS = 0.0104;  // pose known to 2 cm: the gate is at 0.336 m

/// A link at 20 Hz, fed with residuals.
struct Fed {
  RangeLink link{GateSettings{}, LinkSettings{}};
  double t_s = 50.0;
  double S_m2 = kS;

  LinkDecision next(double nu_m, bool clear = true) {
    t_s += 0.05;
    return link.decide({Time::from_s(t_s), nu_m, S_m2, kSigma, clear});
  }

  /// The last decision of n equal residuals.
  LinkDecision times(int n, double nu_m, bool clear = true) {
    LinkDecision out;
    for (int i = 0; i < n; ++i) out = next(nu_m, clear);
    return out;
  }
};

TEST(RangeLink, uses_a_range_inside_the_gate_with_its_variance) {
  Fed fed;
  const LinkDecision out = fed.next(0.05);
  EXPECT_TRUE(out.use);
  EXPECT_EQ(out.reason, RangeReason::kUsed);
  EXPECT_EQ(out.state, LinkState::kGood);
  EXPECT_NEAR(out.gate.R_m2, 0.01, 1e-15);
  EXPECT_EQ(out.advice, LinkAdvice::kNone);
  EXPECT_EQ(out.widen_factor, 1.0);
}

TEST(RangeLink, reports_why_a_range_is_not_used) {
  Fed fed;
  EXPECT_EQ(fed.next(0.5).reason, RangeReason::kBlockedByGate);
  EXPECT_EQ(fed.next(0.5, false).reason, RangeReason::kNlos);
  EXPECT_FALSE(fed.next(0.5).use);
  fed.times(20, 0.5, false);
  EXPECT_EQ(fed.next(0.0).reason, RangeReason::kOutlier);  // fits, but the link is suspect
}

TEST(RangeLink, is_suspect_if_more_than_half_of_twenty_ranges_are_rejected) {
  Fed fed;
  fed.times(9, 0.0);
  EXPECT_EQ(fed.times(10, 1.0, false).state, LinkState::kGood);  // 19 seen, 10 rejected
  Fed half;
  half.times(10, 0.0);
  EXPECT_EQ(half.times(10, 1.0, false).state, LinkState::kGood);  // exactly half
  EXPECT_EQ(half.next(1.0, false).state, LinkState::kSuspect);    // 11 of 20
  EXPECT_FALSE(half.next(0.0).use);
}

TEST(RangeLink, is_good_again_after_ten_accepted_ranges_in_a_row) {
  Fed fed;
  fed.times(20, 1.0, false);
  EXPECT_EQ(fed.times(9, 0.0).state, LinkState::kSuspect);
  fed.next(1.0, false);  // breaks the row
  EXPECT_EQ(fed.times(9, 0.0).state, LinkState::kSuspect);
  const LinkDecision out = fed.next(0.0);
  EXPECT_EQ(out.state, LinkState::kGood);
  EXPECT_TRUE(out.use);
  // Earlier rejections are dropped: one more does not make it suspect again.
  EXPECT_EQ(fed.next(1.0, false).state, LinkState::kGood);
}

TEST(RangeLink, twenty_short_ranges_with_a_common_offset_indicate_a_wrong_pose) {
  Fed fed;
  Rng rng(3, "link");
  LinkDecision out;
  int calls = 0;
  while (out.advice == LinkAdvice::kNone && calls < 100) {
    out = fed.next(-1.0 + kSigma * rng.normal());
    ++calls;
  }
  EXPECT_EQ(calls, 20);
  EXPECT_EQ(out.advice, LinkAdvice::kWeAreWrong);
  EXPECT_EQ(out.widen_factor, 4.0);
  EXPECT_FALSE(out.use);
}

TEST(RangeLink, is_good_again_after_the_pose_covariance_is_widened) {
  Fed fed;
  fed.times(19, -0.5);
  EXPECT_EQ(fed.next(-0.5).advice, LinkAdvice::kWeAreWrong);
  fed.S_m2 = 0.01 + 4.0 * (fed.S_m2 - 0.01) + 0.03;  // what the caller and the drive add
  const LinkDecision out = fed.times(10, -0.5);
  EXPECT_EQ(out.state, LinkState::kGood);
  EXPECT_TRUE(out.use);
}

TEST(RangeLink, raises_one_alarm_after_three_unsuccessful_widenings) {
  Fed fed;
  int wrong = 0;
  int alarms = 0;
  for (int i = 0; i < 400; ++i) {
    const LinkAdvice advice = fed.next(-5.0).advice;
    wrong += advice == LinkAdvice::kWeAreWrong;
    alarms += advice == LinkAdvice::kAlarm;
    if (i == 79) {
      EXPECT_EQ(alarms, 1);  // 3 x 20 ranges for the attempts, 20 more to see them fail
    }
  }
  EXPECT_EQ(wrong, 3);
  EXPECT_EQ(alarms, 1);
}

TEST(RangeLink, resets_the_widening_attempts_once_the_link_is_good) {
  Fed fed;
  fed.times(80, -5.0);
  fed.times(10, 0.0);
  fed.times(19, -5.0);
  EXPECT_EQ(fed.next(-5.0).advice, LinkAdvice::kWeAreWrong);
}

TEST(RangeLink, attributes_an_nlos_offset_to_the_link_not_the_pose) {
  Fed fed;
  for (int i = 0; i < 200; ++i) EXPECT_EQ(fed.next(1.0, false).advice, LinkAdvice::kNone);
  EXPECT_EQ(fed.next(1.0, false).state, LinkState::kSuspect);
}

TEST(RangeLink, attributes_mutually_inconsistent_ranges_to_the_link_not_the_pose) {
  Fed fed;
  for (int i = 0; i < 200; ++i) {
    EXPECT_EQ(fed.next(i % 2 == 0 ? 1.0 : 1.5).advice, LinkAdvice::kNone) << i;
  }
}

TEST(RangeLink, is_lost_after_2_s_of_silence_then_resumes_its_state) {
  Fed fed;
  fed.next(0.0);
  EXPECT_EQ(fed.link.state(Time::from_s(fed.t_s + 1.99)), LinkState::kGood);
  EXPECT_EQ(fed.link.state(Time::from_s(fed.t_s + 2.01)), LinkState::kLost);
  fed.t_s += 10.0;
  EXPECT_TRUE(fed.next(0.0).use);

  fed.times(20, 1.0, false);
  fed.t_s += 10.0;
  EXPECT_EQ(fed.link.state(Time::from_s(fed.t_s)), LinkState::kLost);
  EXPECT_EQ(fed.next(0.0).state, LinkState::kSuspect);
}

TEST(RangeLink, silence_resets_the_run_of_accepted_ranges_and_the_window) {
  Fed fed;
  fed.times(20, 1.0, false);
  fed.times(9, 0.0);
  fed.t_s += 10.0;
  EXPECT_EQ(fed.next(0.0).state, LinkState::kSuspect);
  EXPECT_EQ(fed.times(9, 0.0).state, LinkState::kGood);

  Fed offset;
  offset.times(15, -1.0);
  offset.t_s += 10.0;
  EXPECT_EQ(offset.times(19, -1.0).advice, LinkAdvice::kNone);
  EXPECT_EQ(offset.next(-1.0).advice, LinkAdvice::kWeAreWrong);
}

TEST(RangeLink, long_ranges_indicate_a_wrong_pose_only_after_8_s) {
  // Suspect with the 20th; 8 s at 20 Hz are 160 more.
  Fed fed;
  int calls = 1;
  while (fed.next(1.0).advice == LinkAdvice::kNone && calls < 400) ++calls;
  EXPECT_NEAR(calls, 180, 1);
  // No obstacle shortens a range: short ones mean a wrong pose at once.
  Fed shorter;
  calls = 1;
  while (shorter.next(-1.0).advice == LinkAdvice::kNone && calls < 400) ++calls;
  EXPECT_EQ(calls, 20);
}

TEST(RangeLink, an_obstruction_of_5_s_does_not_widen_the_pose_covariance) {
  Fed fed;
  fed.times(40, 0.0);
  for (int k = 0; k < 100; ++k) {
    const LinkDecision out = fed.next(0.8);
    EXPECT_EQ(out.advice, LinkAdvice::kNone) << k;
    EXPECT_FALSE(out.use) << k;
  }
  EXPECT_TRUE(fed.times(10, 0.0).use);
  // The next obstacle has eight seconds of its own.
  for (int k = 0; k < 100; ++k) EXPECT_EQ(fed.next(0.8).advice, LinkAdvice::kNone) << k;
}

TEST(RangeLink, the_maximum_duration_of_an_obstruction_is_a_setting) {
  LinkSettings settings;
  settings.longer_s = 0.0;
  RangeLink link{GateSettings{}, settings};
  LinkDecision out;
  for (int k = 0; k < 20; ++k) out = link.decide({Time::from_s(0.05 * k), 1.0, kS, kSigma, true});
  EXPECT_EQ(out.advice, LinkAdvice::kWeAreWrong);
}

TEST(RangeLink, refuses_nan_ranges_without_changing_its_state) {
  Fed fed;
  for (int i = 0; i < 50; ++i) {
    EXPECT_EQ(fed.next(std::nan("")).reason, RangeReason::kOutOfLimits);
  }
  fed.S_m2 = 0.0;
  EXPECT_FALSE(fed.next(0.0).use);
  fed.S_m2 = kS;
  EXPECT_TRUE(fed.next(0.0).use);
}

TEST(RangeLink, is_not_lost_before_its_first_range) {
  const RangeLink link{GateSettings{}, LinkSettings{}};
  EXPECT_EQ(link.state(Time::from_s(1e9)), LinkState::kGood);
}

}  // namespace
}  // namespace rali::ranging
