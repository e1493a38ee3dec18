#include "rali/fleet/rounds/finish.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace rali::fleet {
namespace {

FinishInput at(double t_s) {
  FinishInput in;
  in.t = Time::from_s(t_s);
  in.moves = true;
  in.frontier_left = true;
  return in;
}

TEST(FinishWatch, a_weak_median_rssi_over_two_seconds_ends_the_round_permanently) {
  FinishWatch watch{FinishSettings{}};
  const double dbm[] = {-70, -90, -70, -90, -70};  // one weak packet, then another
  for (int k = 0; k < 5; ++k) {
    FinishInput in = at(0.4 * k);
    in.rssi_dbm = dbm[k];
    EXPECT_EQ(watch.step(in).reason, FinishReason::kNone) << k;
  }
  FinishView view;
  for (int k = 5; k < 9; ++k) {
    FinishInput in = at(0.4 * k);
    in.rssi_dbm = -90.0;
    view = watch.step(in);
  }
  EXPECT_EQ(view.reason, FinishReason::kSignal);
  EXPECT_TRUE(view.latched);
  for (int k = 9; k < 30; ++k) {
    FinishInput in = at(0.4 * k);
    in.rssi_dbm = -50.0;
    EXPECT_EQ(watch.step(in).reason, FinishReason::kSignal) << "the edge must not start it again";
  }
  watch.new_round(Time::from_s(13.0));
  EXPECT_EQ(watch.step(at(13.1)).reason, FinishReason::kNone);
}

TEST(FinishWatch, prefers_a_fresh_range_to_the_estimated_distance) {
  FinishWatch watch{FinishSettings{}};
  FinishInput in = at(0.0);
  in.range_m = 40.0;
  in.distance_m = 70.0;  // the estimate has drifted: the range is more accurate
  EXPECT_EQ(watch.step(in).reason, FinishReason::kNone);
  in = at(1.9);
  in.distance_m = 70.0;
  EXPECT_EQ(watch.step(in).reason, FinishReason::kNone);
  in.t = Time::from_s(2.1);
  EXPECT_EQ(watch.step(in).reason, FinishReason::kDistance);
  in = at(3.0);
  in.range_m = 10.0;
  EXPECT_EQ(watch.step(in).reason, FinishReason::kDistance);
}

// The new anchor stood at the old one's limit. Its ranges were received and discarded with the
// distance: after 5 s each tag had lost them and stopped, and the mission ended after 60 m of 200.
TEST(FinishWatch, ignores_weak_radio_and_long_ranges_while_approaching_from_afar) {
  FinishWatch watch{FinishSettings{}};
  for (int k = 0; k < 100; ++k) {
    FinishInput in = at(0.2 * k);
    in.degenerate = true;
    in.range_m = in.distance_m = 66.0 - 0.1 * k;
    in.rssi_dbm = -90.0;
    in.comes_from_afar = true;
    EXPECT_EQ(watch.step(in).reason, FinishReason::kNone) << k;
  }
  FinishInput in = at(20.0);
  in.range_m = 53.0;
  in.rssi_dbm = -70.0;
  EXPECT_EQ(watch.step(in).reason, FinishReason::kNone) << "nothing of before counts";
  in = at(21.0);
  in.range_m = 61.0;
  EXPECT_EQ(watch.step(in).reason, FinishReason::kDistance);
}

// Two measures of it: near by the estimates, so that distance counts, and at once too far by a
// range around a corner. The vehicle never came nearer, and the mission ended in mid-corridor.
TEST(FinishWatch, distance_is_that_of_a_fresh_range) {
  FinishWatch watch{FinishSettings{}};
  FinishInput in = at(0.0);
  in.distance_m = 40.0;
  EXPECT_EQ(watch.apart_m(in), 40.0);
  in.range_m = 62.0;
  EXPECT_EQ(watch.apart_m(in), 62.0);
  in.comes_from_afar = true;
  EXPECT_EQ(watch.step(in).reason, FinishReason::kNone);
  in = at(1.0);
  in.distance_m = 40.0;
  EXPECT_EQ(watch.apart_m(in), 62.0);
  in.t = Time::from_s(2.5);
  EXPECT_EQ(watch.apart_m(in), 40.0) << "an old range";
}

TEST(FinishWatch, reports_unreachable_if_frontiers_remain_without_a_path) {
  FinishWatch watch{FinishSettings{}};
  FinishInput in = at(0.0);
  in.frontier_left = false;
  in.frontier_beyond = true;
  EXPECT_EQ(watch.step(in).reason, FinishReason::kNone);
  in.t = Time::from_s(5.1);
  FinishView view = watch.step(in);
  EXPECT_EQ(view.reason, FinishReason::kUnreachable);
  EXPECT_FALSE(view.latched) << "the one in its way may leave";
  in = at(6.0);
  EXPECT_EQ(watch.step(in).reason, FinishReason::kNone) << "a goal again";
  in = at(7.0);
  in.frontier_left = false;
  EXPECT_EQ(watch.step(in).reason, FinishReason::kNone);
  in.t = Time::from_s(12.1);
  EXPECT_EQ(watch.step(in).reason, FinishReason::kExplored) << "nothing is left beyond";
}

TEST(FinishWatch, warns_10_percent_before_the_distance_limit_and_5_db_before_rssi) {
  FinishWatch watch{FinishSettings{}};
  FinishInput in = at(0.0);
  in.range_m = 53.9;
  EXPECT_FALSE(watch.step(in).warn);
  in = at(0.1);
  in.range_m = 54.1;
  EXPECT_TRUE(watch.step(in).warn);
  FinishWatch radio{FinishSettings{}};
  FinishView view;
  for (int k = 0; k < 3; ++k) {
    in = at(0.1 * k);
    in.rssi_dbm = -81.0;
    view = radio.step(in);
  }
  EXPECT_TRUE(view.warn);
  EXPECT_EQ(view.reason, FinishReason::kNone);
}

TEST(FinishWatch, reports_explored_after_five_seconds_and_clears_with_a_new_frontier) {
  FinishWatch watch{FinishSettings{}};
  FinishInput in = at(0.0);
  in.frontier_left.reset();  // no grid yet: "explored" at the start would be wrong
  EXPECT_EQ(watch.step(in).reason, FinishReason::kNone);
  in.t = Time::from_s(20.0);
  EXPECT_EQ(watch.step(in).reason, FinishReason::kNone);
  in.frontier_left = false;
  in.t = Time::from_s(21.0);
  EXPECT_EQ(watch.step(in).reason, FinishReason::kNone);
  in.t = Time::from_s(25.9);
  EXPECT_EQ(watch.step(in).reason, FinishReason::kNone);
  in.t = Time::from_s(26.0);
  const FinishView view = watch.step(in);
  EXPECT_EQ(view.reason, FinishReason::kExplored);
  EXPECT_FALSE(view.latched);
  EXPECT_EQ(watch.step(at(27.0)).reason, FinishReason::kNone);
}

TEST(FinishWatch, drives_back_before_finishing_if_ranges_are_lost_in_degeneracy) {
  FinishWatch watch{FinishSettings{}};
  FinishInput in = at(0.0);
  in.degenerate = true;
  EXPECT_FALSE(watch.step(in).drive_back);
  in.t = Time::from_s(4.9);
  EXPECT_FALSE(watch.step(in).drive_back);
  in.t = Time::from_s(5.0);
  FinishView view = watch.step(in);
  EXPECT_TRUE(view.drive_back);
  EXPECT_EQ(view.reason, FinishReason::kNone);
  in.t = Time::from_s(9.0);
  in.moves = false;
  EXPECT_EQ(watch.step(in).reason, FinishReason::kNone) << "it listens where it stands";
  in.t = Time::from_s(10.0);
  view = watch.step(in);
  EXPECT_EQ(view.reason, FinishReason::kRangeLost);
  EXPECT_FALSE(view.drive_back);
  in.t = Time::from_s(11.0);
  in.range_m = 30.0;
  EXPECT_EQ(watch.step(in).reason, FinishReason::kNone);
}

TEST(FinishWatch, does_not_require_ranges_without_degeneracy) {
  FinishWatch watch{FinishSettings{}};
  for (int k = 0; k < 100; ++k) {
    const FinishView view = watch.step(at(k));
    EXPECT_FALSE(view.drive_back);
    EXPECT_EQ(view.reason, FinishReason::kNone);
  }
}

TEST(FinishWatch, finishes_above_0_3_m_sigma_and_clears_below_0_24_m) {
  FinishWatch watch{FinishSettings{}};
  const auto reason_at = [&watch](double t_s, double sigma_m) {
    FinishInput in = at(t_s);
    in.range_m = 10.0;
    in.degenerate = true;
    in.sigma_m = sigma_m;
    return watch.step(in).reason;
  };
  EXPECT_EQ(reason_at(0.0, 0.0), FinishReason::kNone);
  EXPECT_EQ(reason_at(1.0, 0.31), FinishReason::kSigma);
  EXPECT_EQ(reason_at(2.0, 0.25), FinishReason::kSigma);
  EXPECT_EQ(reason_at(3.0, 0.23), FinishReason::kNone);
}

// Two vehicles stopped a metre beside each other in each round. There ranges do not constrain the
// direction of travel, so their sigma stayed large and they explored nothing more.
TEST(FinishWatch, ignores_a_large_position_sigma_close_to_the_anchor) {
  FinishWatch watch{FinishSettings{}};
  const auto reason_at = [&watch](double t_s, double range_m, double sigma_m) {
    FinishInput in = at(t_s);
    in.range_m = range_m;
    in.degenerate = true;
    in.sigma_m = sigma_m;
    return watch.step(in).reason;
  };
  EXPECT_EQ(reason_at(1.0, 8.0, 0.1), FinishReason::kNone);
  EXPECT_EQ(reason_at(2.0, 1.2, 0.5), FinishReason::kNone);
  EXPECT_EQ(reason_at(3.0, 8.0, 0.2), FinishReason::kNone) << "held again";
  EXPECT_EQ(reason_at(4.0, 8.0, 0.5), FinishReason::kSigma);
}

// After some stops in a long tunnel every vehicle's sigma is above the bound: a round that counted
// all of it would end at its start, again and again, with the mission.
TEST(FinishWatch, counts_only_position_uncertainty_gained_since_the_round_started) {
  FinishWatch watch{FinishSettings{}};
  watch.new_round(Time::from_s(0.0));
  const auto reason_at = [&watch](double t_s, double sigma_m) {
    FinishInput in = at(t_s);
    in.range_m = 10.0;
    in.degenerate = true;
    in.sigma_m = sigma_m;
    return watch.step(in).reason;
  };
  EXPECT_EQ(reason_at(1.0, 0.4), FinishReason::kNone);
  EXPECT_EQ(reason_at(2.0, 0.49), FinishReason::kNone);   // grown by 0.28 m
  EXPECT_EQ(reason_at(3.0, 0.51), FinishReason::kSigma);  // by 0.32 m
  watch.new_round(Time::from_s(4.0));
  EXPECT_EQ(reason_at(5.0, 0.51), FinishReason::kNone);
}

TEST(FinishWatch, a_low_battery_and_the_operator_end_it) {
  FinishWatch battery{FinishSettings{}};
  FinishInput in = at(0.0);
  in.battery_fraction = 0.05;
  EXPECT_EQ(battery.step(in).reason, FinishReason::kBattery);
  FinishWatch stopped{FinishSettings{}};
  in = at(0.0);
  in.operator_stop = true;
  EXPECT_EQ(stopped.step(in).reason, FinishReason::kOperator);
}

TEST(FinishWatch, paper_mode_ignores_degeneracy_position_sigma_and_battery) {
  FinishSettings settings;
  settings.rule = FinishRule::kPaper;
  FinishWatch watch(settings);
  for (int k = 0; k < 30; ++k) {
    FinishInput in = at(k);
    in.degenerate = true;
    in.sigma_m = 5.0;
    in.battery_fraction = 0.01;
    const FinishView view = watch.step(in);
    EXPECT_EQ(view.reason, FinishReason::kNone);
    EXPECT_FALSE(view.drive_back);
  }
  FinishInput in = at(31.0);
  in.range_m = 61.0;
  EXPECT_EQ(watch.step(in).reason, FinishReason::kDistance);
}

TEST(FinishWatch, nan_and_late_inputs_change_nothing) {
  FinishWatch watch{FinishSettings{}};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  FinishInput in = at(10.0);
  in.rssi_dbm = in.range_m = in.distance_m = in.battery_fraction = nan;
  in.sigma_m = nan;
  EXPECT_EQ(watch.step(in).reason, FinishReason::kNone);
  in = at(9.0);
  in.range_m = 1e6;
  EXPECT_EQ(watch.step(in).reason, FinishReason::kNone);
}

}  // namespace
}  // namespace rali::fleet
