#include <cmath>
#include <cstring>
#include <limits>

#include <gtest/gtest.h>

#include "rali/vehicle/staged_for_test.hpp"

namespace rali::vehicle {
namespace {

using geometry::Vec3;
using odometry::DenseAugmentedFilter;
using ranging::RangeReason;
using ranging::RangeUse;
using sensor::RangeSample;

TEST(RangeStage, a_range_update_matches_the_hand_computed_gain) {
  Staged s;
  // Between the antennas, across the line: 0.2901 m2 (0.04 + 0.5^2 + 1e-4), and vertically
  // 0.0801 m2 (0.04 + 1e-4 + the error of level, 0.2^2). The mean of the second-order term, half
  // their sum / 10 = 18.5 mm, is not subtracted.
  // S: own position 0.04, the peer's 0.04, bias 0.01, stamps 1 (m/s)^2 (0.02 s)^2, the range 0.1^2
  // + 0.0101^2, and the second-order term half of 0.02901^2 + 0.00801^2.
  const double S = 0.04 + 0.04 + 0.01 + 0.0004 + 0.01010201 + 0.5 * (8.41580e-4 + 6.41601e-5);
  const RangeUse use = s.one(0.0, 10.1);
  EXPECT_EQ(use.reason, RangeReason::kUsed);
  EXPECT_NEAR(use.predicted_m, 10.0, 1e-9);
  EXPECT_NEAR(use.residual_m, 0.1, 1e-9);
  EXPECT_NEAR(use.sigma_m, std::sqrt(S), 1e-7);
  EXPECT_EQ(use.bias_m, 0.0);
  // Longer than predicted: the pose moves back, by 0.04 / S of the residual.
  EXPECT_NEAR(s.filter.now.T_odom_body.p.x(), -0.1 * 0.04 / S, 1e-7);
  EXPECT_NEAR(s.effect.shift_m, 0.1 * 0.04 / S, 1e-7);
  EXPECT_EQ(s.effect.from, kPeer);
  // Augmented states: landmark, stamps, bias.
  ASSERT_EQ(s.filter.augmented().size(), 5);
  EXPECT_NEAR(s.filter.augmented().mean[0], 10.0 + 0.1 * 0.04 / S, 1e-7);
  EXPECT_NEAR(s.filter.augmented().mean[4], 0.1 * 0.01 / S, 1e-7);
}

TEST(RangeStage, the_direction_of_an_exchange_makes_no_difference) {
  Staged forth;
  Staged back;
  RangeSample turned = Staged::sample(0.0, 10.1);
  std::swap(turned.from, turned.to);
  back.stage.add(turned, back.out);
  back.run(0.0);
  EXPECT_EQ(forth.one(0.0, 10.1).residual_m, back.uses().back().residual_m);
}

TEST(RangeStage, prediction_includes_a_calibrated_bias) {
  VehicleSettings settings = settings_with_prior();
  settings.peers[0].bias_m = 0.5;
  Staged s(settings);
  const RangeUse use = s.one(0.0, 10.5);
  EXPECT_EQ(use.bias_m, 0.5);
  EXPECT_NEAR(use.predicted_m, 10.5, 1e-9);
}

TEST(RangeStage, refuses_ranges_with_unknown_vehicles_or_antennas_at_once) {
  Staged s;
  RangeSample strange = Staged::sample(0.0, 10.0);
  strange.to = VehicleId{9};
  s.stage.add(strange, s.out);
  strange = Staged::sample(0.0, 10.0);
  strange.from = VehicleId{3};  // between two others
  s.stage.add(strange, s.out);
  strange = Staged::sample(0.0, 10.0);
  strange.to_antenna = 1;  // the peer has only one
  s.stage.add(strange, s.out);
  strange = Staged::sample(0.0, 10.0);
  strange.from_antenna = 255;
  s.stage.add(strange, s.out);
  ASSERT_EQ(s.uses().size(), 4U);
  for (const RangeUse& use : s.uses()) EXPECT_EQ(use.reason, RangeReason::kUnknownId);
  s.run(1.0);
  EXPECT_EQ(s.uses().size(), 4U);
}

TEST(RangeStage, uses_ranges_only_to_a_peer_recently_reported_at_standstill) {
  Staged s;
  EXPECT_EQ(s.one(1.4, 8.6).reason, RangeReason::kUsed);
  EXPECT_EQ(s.one(1.6, 8.4).reason, RangeReason::kNoPose);  // reported 1.5 s ago
  s.report(1.6, false);
  EXPECT_EQ(s.one(1.7, 8.3).reason, RangeReason::kNoPose);  // in motion

  VehicleSettings settings = settings_with_prior();
  RangeStage never(kSelf, settings);
  DenseAugmentedFilter filter;
  OutputList out;
  never.add(Staged::sample(0.0, 10.0), out);
  static_cast<void>(never.run(Time::from_s(1.0), &filter, kGravity, geometry::SE3{}, out));
  ASSERT_EQ(out.size(), 1U);
  EXPECT_EQ(std::get<RangeUse>(out[0]).reason, RangeReason::kNoPose);
  EXPECT_TRUE(filter.applied.empty());
}

TEST(RangeStage, without_a_filter_or_with_ranging_disabled_only_reports_ranges) {
  Staged s;
  s.add(0.0, 10.0);
  static_cast<void>(s.stage.run(Time::from_s(1.0), nullptr, kGravity, std::nullopt, s.out));
  ASSERT_EQ(s.uses().size(), 1U);
  EXPECT_EQ(s.uses()[0].reason, RangeReason::kNoPose);

  VehicleSettings settings = settings_with_prior();
  settings.ranging.use = false;
  Staged off(settings);
  off.add(0.0, 10.0);
  off.run(1.0);
  ASSERT_EQ(off.uses().size(), 1U);
  EXPECT_EQ(off.uses()[0].reason, RangeReason::kNoPose);
}

TEST(RangeStage, a_range_older_than_the_filter_history_is_late) {
  Staged s;
  EXPECT_EQ(s.one(1.0, 9.0).reason, RangeReason::kUsed);
  EXPECT_EQ(s.one(0.95, 9.05).reason, RangeReason::kUsed);
  EXPECT_EQ(s.one(0.85, 9.15).reason, RangeReason::kLate);
}

TEST(RangeStage, before_the_filter_is_initialised_no_range_is_late) {
  Staged s;
  s.filter.found_itself = false;
  EXPECT_EQ(s.one(0.0, 10.0).reason, RangeReason::kNoPose);
  s.filter.found_itself = true;
  EXPECT_EQ(s.one(0.1, 9.9).reason, RangeReason::kUsed);
  s.filter.found_itself = false;
  EXPECT_EQ(s.one(0.2, 9.8).reason, RangeReason::kLate);
}

TEST(RangeStage, refuses_nan_and_implausible_ranges_as_out_of_limits) {
  Staged s;
  const double inf = std::numeric_limits<double>::infinity();
  for (const double bad : {0.1, -1.0, 301.0, inf, std::nan("")}) {
    EXPECT_EQ(s.one(0.0, bad).reason, RangeReason::kOutOfLimits) << bad;
  }
  EXPECT_EQ(s.one(0.0, 10.0).reason, RangeReason::kUsed);
}

TEST(RangeStage, distinguishes_a_range_jump_from_a_gated_innovation) {
  Staged s;
  EXPECT_EQ(s.one(0.0, 10.0).reason, RangeReason::kUsed);
  EXPECT_EQ(s.one(0.05, 15.0).reason, RangeReason::kOutlier);
  Staged misses;
  EXPECT_EQ(misses.one(0.0, 12.0).reason, RangeReason::kBlockedByGate);  // 2 m are 6 sds
  EXPECT_TRUE(misses.filter.applied.empty());
  EXPECT_EQ(misses.effect.shift_m, 0.0);
}

// Behind a wall the signal took a longer way, by any length: at the predicted distance of 10 m a
// range of 10.1 m says nothing, one of 9.95 m says that the other is not as far.
TEST(RangeStage, takes_ranges_through_mapped_walls_as_upper_bounds_only) {
  Staged s;
  s.filter.surfaces = 2;
  const RangeUse use = s.one(0.0, 9.95);
  ASSERT_EQ(use.reason, RangeReason::kUsed) << use.residual_m;
  EXPECT_LE(use.p_los, 0.1);
  EXPECT_GT(s.filter.applied_R[0], 25.0 * 0.0101 - 1e-9);
  for (const double longer_m : {10.1, 12.5}) {
    Staged longer;
    longer.filter.surfaces = 2;
    EXPECT_EQ(longer.one(0.0, longer_m).reason, RangeReason::kNlos) << longer_m;
    EXPECT_TRUE(longer.filter.applied.empty());
  }
  Staged one_wall;
  one_wall.filter.walls_x_m = {9.3};  // the one the antenna hangs on
  static_cast<void>(one_wall.one(0.0, 10.02));
  EXPECT_LT(one_wall.filter.applied_R[0], 0.011);
}

// The peer is 0.8 m to the side, known to 0.54 m (0.05 rad at 10 m) or to 0.2 m.
TEST(RangeStage, walls_block_a_range_only_if_they_do_wherever_the_peer_may_be) {
  for (const double sigma_rad : {0.05, 0.001}) {
    VehicleSettings settings = settings_with_prior();
    settings.peers[0].prior->T_self_peer.p.y() = 0.8;
    settings.peers[0].prior->sigma_rad = sigma_rad;
    Staged s(settings);
    s.filter.walls_y_m = {0.1, 0.2};
    const RangeUse use = s.one(0.0, 9.98);
    EXPECT_EQ(use.p_los <= 0.1, sigma_rad < 0.01) << use.p_los;
  }
}

TEST(RangeStage, marks_a_burst_of_long_ranges_as_nlos_from_the_first) {
  Staged s;
  s.filter.now.v_odom_mps = Vec3::Zero();
  s.filter.P(3, 3) = 1e-4;
  int used = 0;
  for (int k = 0; k < 100; ++k) {
    const bool burst = k >= 40 && k < 70;
    s.report(0.05 * k, true);
    const double noise_m = k % 2 == 0 ? 0.02 : -0.02;
    const RangeUse use = s.one(0.05 * k, 10.0 + noise_m + (burst ? 0.6 : 0.0));
    if (burst) {
      EXPECT_EQ(use.reason, RangeReason::kNlos) << k;
    }
    used += use.used();
  }
  EXPECT_GE(used, 66);  // 70 less those that show that it is over
  EXPECT_NEAR(s.filter.now.T_odom_body.p.x(), 0.0, 0.02);
}

// Its landmark was removed after 8 s, and placed again by the ranges that were too long.
TEST(RangeStage, keeps_the_landmark_while_an_obstacle_stands_between) {
  Staged s;
  s.filter.now.v_odom_mps = Vec3::Zero();
  s.filter.P(3, 3) = 1e-4;
  for (int k = 0; k < 500; ++k) {
    const bool obstructed = k >= 40 && k < 440;  // 20 s
    s.report(0.05 * k, true);
    const RangeUse use = s.one(0.05 * k, 10.0 + (k % 2 == 0 ? 0.02 : -0.02) + 0.6 * obstructed);
    if (obstructed) {
      EXPECT_EQ(use.reason, RangeReason::kNlos) << k;
    }
    if (k >= 450) {
      EXPECT_TRUE(use.used()) << k;
    }
  }
  EXPECT_NEAR(s.filter.now.T_odom_body.p.x(), 0.0, 0.02);
}

TEST(RangeStage, consistently_short_ranges_widen_the_pose_covariance) {
  Staged s;
  s.filter.now.v_odom_mps = Vec3::Zero();
  for (int k = 0; k < 20; ++k) {
    s.report(0.05 * k, true);
    EXPECT_EQ(s.filter.widened, 1.0);
    EXPECT_EQ(s.one(0.05 * k, 8.0).reason, RangeReason::kBlockedByGate);
  }
  EXPECT_EQ(s.filter.widened, 4.0);
}

TEST(RangeStage, consecutive_ranges_get_a_larger_variance_for_their_common_error) {
  Staged s;
  for (int k = 0; k < 5; ++k) static_cast<void>(s.one(0.05 * k, 10.0 - 0.05 * k));
  ASSERT_EQ(s.filter.applied_R.size(), 5U);
  for (std::size_t k = 1; k < 5; ++k) {
    EXPECT_GT(s.filter.applied_R[k], 1.2 * s.filter.applied_R[0]) << k;
  }
}

TEST(RangeStage, processes_ranges_in_time_order_up_to_the_scan_end) {
  Staged s;
  for (const double t_s : {0.3, 0.1, 0.45, 0.2}) s.add(t_s, 10.0 - t_s);
  EXPECT_TRUE(s.uses().empty());
  s.run(0.4);
  ASSERT_EQ(s.uses().size(), 3U);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(s.filter.asked[k], Time::from_s(0.1 * static_cast<double>(k + 1)));
    EXPECT_EQ(s.uses()[k].reason, RangeReason::kUsed);
  }
  s.stage.flush(s.out);  // the scan that covers the last one never comes
  ASSERT_EQ(s.uses().size(), 4U);
  EXPECT_EQ(s.uses()[3].reason, RangeReason::kNoPose);
  s.stage.flush(s.out);
  EXPECT_EQ(s.uses().size(), 4U);
}

TEST(RangeStage, removes_only_the_landmark_states_of_a_peer_that_drove_off) {
  Staged s;
  static_cast<void>(s.one(0.0, 10.1));
  ASSERT_EQ(s.filter.augmented().size(), 5);
  const double tau_s = s.filter.augmented().mean[3];
  const double bias_m = s.filter.augmented().mean[4];
  s.report(0.1, false);
  EXPECT_EQ(s.one(0.1, 9.9).reason, RangeReason::kNoPose);
  ASSERT_EQ(s.filter.augmented().size(), 2);
  EXPECT_EQ(s.filter.augmented().mean[0], tau_s);
  EXPECT_EQ(s.filter.augmented().mean[1], bias_m);
  // At standstill again, elsewhere: the prior of the start no longer holds.
  s.report(0.2, true);
  EXPECT_EQ(s.one(0.2, 9.8).reason, RangeReason::kNoPose);
  EXPECT_EQ(s.filter.augmented().size(), 2);
}

// An anchor that was passed reported motion for two scans. Its landmark was removed, initialised
// again on the wrong side of the vehicle beside it, and the round ended.
TEST(RangeStage, keeps_the_landmark_of_a_peer_displaced_by_only_2_cm) {
  for (const double off_m : {0.02, 0.5}) {
    Staged s;
    PeerPose pose;
    s.stage.on(PeerStatus{kPeer, Time::from_s(0.0), true, pose});
    EXPECT_TRUE(s.one(0.1, 9.9).used());
    const auto states = s.filter.augmented().size();
    pose.T_start_body.p.x() = off_m;
    s.stage.on(PeerStatus{kPeer, Time::from_s(0.2), false, pose});
    EXPECT_FALSE(s.one(0.3, 9.7).used()) << "it may be driving off";
    EXPECT_EQ(s.filter.augmented().size(), off_m < 0.1 ? states : states - 3) << off_m;
    s.stage.on(PeerStatus{kPeer, Time::from_s(0.4), true, pose});
    EXPECT_TRUE(s.one(0.5, 9.5 + off_m).used()) << off_m;
  }
}

TEST(RangeStage, initialises_a_far_peer_in_a_passage_from_ranges_while_driving) {
  VehicleSettings settings = settings_with_prior();
  settings.peers[0].prior.reset();
  Staged s(settings);
  s.filter.axis = Vec3::UnitX();
  double t_s = 0.0;
  while (s.filter.augmented().size() == 0 && t_s < 5.0) {
    s.report(t_s, true);
    EXPECT_EQ(s.one(t_s, 60.0 - t_s).reason, RangeReason::kNoPose);
    t_s += 0.1;
  }
  // Stamps, bias and landmark. At 58 m the lateral sigma is 4.9 m: along the passage it is 4.9^2 /
  // (2 58) nearer for that.
  ASSERT_EQ(s.filter.augmented().size(), 5);
  EXPECT_NEAR(s.filter.augmented().mean[2], 60.0 - 0.207, 0.01);
  // Its error is that of the bias from which it was initialised, with the opposite sign.
  EXPECT_NEAR(s.filter.augmented().covariance(1, 2), -s.filter.augmented().covariance(1, 1), 1e-9);
  const std::size_t before = s.uses().size();
  EXPECT_EQ(s.one(t_s, 60.0 - t_s).reason, RangeReason::kUsed);
  EXPECT_EQ(s.uses().size(), before + 1);
  // In a passage the lateral position is kept open: the filter is updated by the slices, and from
  // afar not in the lateral position.
  EXPECT_TRUE(s.filter.applied.empty());
  EXPECT_EQ(s.filter.replaced, 1);
  EXPECT_NEAR(s.filter.augmented().mean[3], 0.0, 0.05);
  EXPECT_GT(s.filter.augmented().covariance(3, 3), 2.0);
}

// Of two vehicles side by side one drove 40 m ahead and stopped. Its ranges from the start and from
// there, 3 and 43 m, were taken for those of one place: the landmark was initialised behind, and
// the other vehicle's pose drove backwards with it.
TEST(RangeStage, a_peer_that_drove_ahead_before_it_was_located_is_initialised_ahead) {
  for (const bool received : {true, false}) {  // its reports while it drives
    VehicleSettings settings = settings_with_prior();
    settings.peers[0].prior.reset();
    Staged s(settings);
    s.filter.axis = Vec3::UnitX();
    s.filter.now.v_odom_mps.setZero();
    PeerPose pose;
    const auto report = [&](double t_s, bool at_rest) {
      s.stage.on(PeerStatus{kPeer, Time::from_s(t_s), at_rest, pose});
    };
    for (int k = 0; k < 40; ++k) {
      report(0.1 * k, true);
      static_cast<void>(s.one(0.1 * k, 3.0));
    }
    for (int k = 0; k < 200; ++k) {
      pose.T_start_body.p.x() += 0.2;
      if (!received) continue;
      report(4.0 + 0.1 * k, false);
      static_cast<void>(s.one(4.0 + 0.1 * k, 3.0 + pose.T_start_body.p.x()));
    }
    static_cast<void>(s.filter.advance_to(Time::from_s(24.0)));
    s.filter.now.v_odom_mps = Vec3::UnitX();
    for (double driven_m = 0.0; driven_m < 8.0 && s.filter.augmented().size() == 0;
         driven_m += 0.1) {
      report(24.0 + driven_m, true);
      static_cast<void>(s.one(24.0 + driven_m, 43.0 - driven_m));
    }
    ASSERT_EQ(s.filter.augmented().size(), 5) << received;
    EXPECT_NEAR(s.filter.augmented().mean[2], 43.0, 0.5) << received;
  }
}

TEST(RangeStage, passes_a_peer_whose_lateral_prior_is_wrong_by_metres) {
  // It is 1.2 m to the left, with a prior 4 m to the right, 40 m ahead.
  VehicleSettings settings = settings_with_prior();
  settings.peers[0].prior->T_self_peer.p = Vec3(40.0, -4.0, 0.0);
  settings.peers[0].prior->sigma_rad = 0.08;
  Staged s(settings);
  s.filter.axis = Vec3::UnitX();
  s.filter.P.diagonal().segment<3>(3) << 1e-4, 1e-4, 1e-4;
  s.filter.P.diagonal().segment<3>(6) << 1e-4, 1e-8, 1e-8;
  double worst_m = 0.0;
  for (int k = 1; k < 700; ++k) {
    const double t_s = 0.1 * k;
    s.filter.P(6, 6) += 1e-5;  // process noise of the vehicle
    s.report(t_s, true);
    static_cast<void>(s.one(t_s, std::hypot(40.0 - t_s, 1.2)));
    worst_m = std::max(worst_m, std::abs(s.filter.now.T_odom_body.p.x() - t_s));
  }
  EXPECT_LT(worst_m, 0.5);
  EXPECT_NEAR(s.filter.now.T_odom_body.p.x(), 69.9, 0.25);
  EXPECT_NEAR(std::abs(s.filter.augmented().mean[1]), 1.2, 0.3);
}

TEST(RangeStage, the_same_ranges_give_the_same_bytes) {
  Staged a;
  Staged b;
  for (Staged* s : {&a, &b}) {
    for (int k = 0; k < 20; ++k) {
      s->report(0.05 * k, true);
      static_cast<void>(s->one(0.05 * k, 10.0 - 0.05 * k + 0.01 * (k % 3)));
    }
  }
  ASSERT_EQ(a.filter.P.size(), b.filter.P.size());
  const auto bytes = static_cast<std::size_t>(a.filter.P.size()) * sizeof(double);
  EXPECT_EQ(std::memcmp(a.filter.P.data(), b.filter.P.data(), bytes), 0);
}

}  // namespace
}  // namespace rali::vehicle
