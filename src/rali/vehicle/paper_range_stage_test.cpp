#include "rali/vehicle/paper_range_stage.hpp"

#include <bit>
#include <cmath>

#include <gtest/gtest.h>

#include "rali/odometry/room_for_test.hpp"
#include "rali/vehicle/paper_ranges_for_test.hpp"
#include "rali/vehicle/vehicle.hpp"

namespace rali::vehicle {
namespace {

using geometry::SE3;
using geometry::Vec3;
using odometry::KeyframeInertia;
using odometry::KeyframeMove;
using ranging::RangeReason;
using ranging::RangeUse;
using sensor::RangeSample;

TEST(PaperRanges, correct_drift_along_a_degenerate_corridor) {
  Bench b;
  const auto move = b.one({20.0, 0.0, 0.0}, 20.5);
  ASSERT_TRUE(move);
  EXPECT_LT((move->T_odom_body.p - Vec3(20.0 + kShift, 0.0, 0.0)).norm(), 1e-5);
  EXPECT_EQ(b.count(RangeReason::kUsed), 20);
  const auto findings = b.all<Finding>();
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].id, "ranging.paper_corrections");
  EXPECT_EQ(findings[0].value, 1.0);
}

TEST(PaperRanges, report_residuals_against_the_pose_before_the_correction) {
  Bench b;
  static_cast<void>(b.one({20.0, 0.0, 0.0}, 20.5));
  const RangeUse last = b.all<RangeUse>().back();
  EXPECT_NEAR(last.predicted_m, 20.024984, 1e-6);
  EXPECT_NEAR(last.residual_m, 0.475016, 1e-6);
}

TEST(PaperRanges, do_nothing_without_degeneracy) {
  Bench b;
  b.seen = &kRoom;
  EXPECT_FALSE(b.one({20.0, 0.0, 0.0}, 20.5));
  EXPECT_EQ(b.count(RangeReason::kNotNeeded), 20);
}

TEST(PaperRanges, do_nothing_while_the_residual_is_below_the_gap) {
  Bench b;
  EXPECT_FALSE(b.one({20.0, 0.0, 0.0}, 20.3));
  EXPECT_EQ(b.count(RangeReason::kNotNeeded), 20);
}

TEST(PaperRanges, below_the_gap_still_act_as_factors_under_degeneracy) {
  Bench b;
  b.settings.ranging.paper.factor = ranging::PaperFactor::kDegenerate;
  const auto move = b.one({20.0, 0.0, 0.0}, 20.1);  // 0.075 m more than it is
  ASSERT_TRUE(move);
  EXPECT_EQ(b.count(RangeReason::kUsed), 20);
  EXPECT_NEAR(move->T_odom_body.p.x(), 20.0375, 0.0375);
  ASSERT_TRUE(move->known);
  EXPECT_NEAR(move->known->sigma_m, 0.1, 2e-3);
  EXPECT_NEAR(move->known->place_sigma_m, std::hypot(0.2, 0.1), 1e-2);  // of prior and constant
  EXPECT_NEAR(move->known->shift_m * move->known->e_odom.x(), move->T_odom_body.p.x() - 20.0, 1e-9);
}

TEST(PaperRanges, report_the_degenerate_direction_to_the_odometry) {
  Bench b;
  b.begin();
  const auto along = b.stage->degenerate_direction(kCorridor, Vec3::UnitZ());
  ASSERT_TRUE(along && std::abs(along->x()) > 1.0 - 1e-9);
  EXPECT_FALSE(b.stage->degenerate_direction(kRoom, Vec3::UnitZ()));
}

TEST(PaperRanges, are_refused_nearly_perpendicular_to_the_degenerate_direction) {
  // Test T9: (2, 10), u = 10.1: sensitivity 7.12.
  Bench b;
  b.p_peer = {0.0, -10.0, 0.0};
  b.settings.ranging.paper.gap_m = 0.05;
  EXPECT_FALSE(b.one({2.0, 0.0, 0.0}, 10.1));
  EXPECT_EQ(b.count(RangeReason::kBadGeometry), 1);
  EXPECT_EQ(b.count(RangeReason::kNotNeeded), 19);
}

TEST(PaperRanges, are_refused_if_the_range_circle_misses_the_degenerate_line) {
  // (0.5, 3), u = 2.5: the line passes 0.5 m beside the circle, more than gap_m.
  Bench b;
  b.p_peer = {0.0, -3.0, 0.0};
  EXPECT_FALSE(b.one({0.5, 0.0, 0.0}, 2.5));
  EXPECT_EQ(b.count(RangeReason::kBlockedByGate), 1);
}

TEST(PaperRanges, are_refused_for_a_10_m_correction_except_in_literal_mode) {
  Bench b;
  EXPECT_FALSE(b.one({20.0, 0.0, 0.0}, 30.0));  // s = 9.98 m
  EXPECT_EQ(b.count(RangeReason::kBlockedByGate), 1);
  Bench printed;
  printed.settings.odometry.paper.literal = true;
  const auto move = printed.one({20.0, 0.0, 0.0}, 30.0);
  ASSERT_TRUE(move);
  EXPECT_NEAR(move->T_odom_body.p.x(), std::sqrt(30.0 * 30.0 - 1.0), 1e-5);
}

TEST(PaperRanges, are_projected_to_the_horizontal_plane_except_in_literal_mode) {
  // Test T9: u = 20.5, dz = 1.5: 0.420578 with `project`; in the paper 20.5 is taken flat.
  for (const bool literal : {false, true}) {
    Bench b;
    b.settings.peers[0].antennas_body_m = {Vec3(0.0, 0.0, 1.5)};
    b.settings.odometry.paper.literal = literal;
    b.settings.ranging.paper.factor = ranging::PaperFactor::kNone;
    const auto move = b.one({20.0, 0.0, 0.0}, 20.5);
    ASSERT_TRUE(move);
    EXPECT_NEAR(move->T_odom_body.p.x(), 20.0 + (literal ? kShift : 0.420578), 1e-6);
  }
}

TEST(PaperRanges, are_compared_with_the_pose_at_their_stamp_or_keyframe) {
  // The newest is 0.05 s old, the vehicle was at 19.95 m then.
  for (const bool measured : {true, false}) {
    Bench b;
    b.v_mps = {1.0, 0.0, 0.0};
    b.settings.ranging.paper.factor = ranging::PaperFactor::kNone;
    b.settings.ranging.paper.range_time =
        measured ? ranging::PaperRangeTime::kMeasured : ranging::PaperRangeTime::kKeyframe;
    b.begin();
    b.ranges(0.15, 1.1, 20.5);
    const auto move = b.scan(1.15, {20.0, 0.0, 0.0});
    ASSERT_TRUE(move);
    EXPECT_NEAR(move->T_odom_body.p.x(), 20.0 + kShift + (measured ? 0.05 : 0.0), 1e-5);
  }
}

/// Keyframes each 5 m without ranges, then one with them.
std::optional<KeyframeMove> drive(Bench& b, bool second_sees) {
  b.begin();
  for (int k = 1; k <= 3; ++k) {
    b.seen = second_sees && k == 2 ? &kRoom : &kCorridor;
    static_cast<void>(b.scan(0.1 + 5.0 * k, {5.0 * k, 0.0, 0.0}));
  }
  b.seen = &kCorridor;
  b.ranges(19.2, 20.1, 20.5);
  return b.scan(20.1, {20.0, 0.0, 0.0});
}

TEST(PaperRanges, distribute_a_correction_over_degenerate_keyframes_since_the_last_correction) {
  for (const bool second_sees : {false, true}) {
    Bench b;
    const auto move = drive(b, second_sees);
    ASSERT_TRUE(move);
    ASSERT_EQ(move->earlier.size(), 4U);
    const std::vector<double> quarters{0.0, 0.25, 0.5, 0.75};
    const std::vector<double> thirds{0.0, 1.0 / 3.0, 1.0 / 3.0, 2.0 / 3.0};
    for (std::size_t i = 0; i < 4; ++i) {
      const double fraction = second_sees ? thirds[i] : quarters[i];
      EXPECT_NEAR(move->earlier[i].p.x(), 5.0 * static_cast<double>(i) + fraction * kShift, 1e-5);
    }
    EXPECT_NEAR(move->T_odom_body.p.x(), 20.0 + kShift, 1e-5);
    const auto reported = b.all<KeyframeCorrected>();
    ASSERT_EQ(reported.size(), 3U);
    for (std::uint32_t i = 0; i < 3; ++i) {
      EXPECT_EQ(reported[i].id.seq, i + 1);
      EXPECT_EQ(reported[i].T_local_body.p, move->earlier[i + 1].p);
    }
  }
}

TEST(PaperRanges, correct_only_the_newest_keyframe_without_distribution) {
  Bench b;
  b.settings.ranging.paper.fraction = ranging::PaperFraction::kNone;
  const auto move = drive(b, false);
  ASSERT_TRUE(move);
  EXPECT_NEAR(move->earlier[3].p.x(), 15.0, 1e-5);
  EXPECT_NEAR(move->T_odom_body.p.x(), 20.0 + kShift, 1e-5);
  EXPECT_TRUE(b.all<KeyframeCorrected>().empty());
}

TEST(PaperRanges, act_only_as_a_factor_if_the_correction_is_a_guess) {
  // Odometry 0.05 m over one step, range 0.1 m, residual 0.475: 0.475 x 0.0025/(0.0025 + 0.01).
  Bench b;
  b.settings.ranging.paper.correct_then_factor = ranging::PaperThenFactor::kGuess;
  const auto move = b.one({20.0, 0.0, 0.0}, 20.5);
  ASSERT_TRUE(move);
  EXPECT_NEAR(move->T_odom_body.p.x() - 20.0, 0.095, 1e-3);
  EXPECT_LT(std::abs(move->T_odom_body.p.y()), 0.01);
}

TEST(PaperRanges, wait_for_the_minimum_samples_of_the_smoother) {
  Bench b;
  b.begin();
  b.ranges(0.95, 1.1, 20.5);  // only four
  EXPECT_FALSE(b.scan(1.1, {20.0, 0.0, 0.0}));
}

TEST(PaperRanges, forget_the_position_of_a_peer_that_drove_off) {
  Bench b;
  b.begin();
  b.stage->on(PeerStatus{kPeer, Time::from_s(0.12), false});
  b.ranges(0.15, 1.1, 20.5);  // at standstill again, elsewhere
  EXPECT_FALSE(b.scan(1.1, {20.0, 0.0, 0.0}));
  EXPECT_EQ(b.count(RangeReason::kNoPose), 20);
}

/// Good ranges, wrong ones, those of unknown vehicles, and those that no scan covers.
void feed_mixture(Bench& b) {
  b.begin();
  b.ranges(0.15, 1.1, 20.5);
  RangeSample odd;
  odd.t = Time::from_s(0.52);
  odd.from = kPeer;
  odd.to = kSelf;
  for (const double range_m : {-1.0, 0.0, 1e9, std::nan(""), 90.0}) {
    odd.range_m = range_m;
    b.stage->add(odd, b.out);
  }
  odd.range_m = 20.5;
  odd.to_antenna = 7;
  b.stage->add(odd, b.out);
  odd.to = VehicleId{9};
  b.stage->add(odd, b.out);
  static_cast<void>(b.scan(1.1, {20.0, 0.0, 0.0}));
  b.ranges(1.15, 2.6, 20.5);
  static_cast<void>(b.scan(2.0, {20.0, 0.0, 0.0}));
  b.stage->flush(b.out);
}

TEST(PaperRanges, each_produce_exactly_one_result) {
  Bench b;
  feed_mixture(b);
  const auto uses = b.all<RangeUse>();
  EXPECT_EQ(uses.size(), 20U + 7U + 30U);
  EXPECT_EQ(b.count(RangeReason::kUnknownId), 2);
  EXPECT_EQ(b.count(RangeReason::kOutOfLimits), 4);
  EXPECT_EQ(b.count(RangeReason::kOutlier), 1);
  EXPECT_EQ(b.count(RangeReason::kNoPose), 12);  // after the last scan
}

TEST(PaperRanges, same_events_give_the_same_bits) {
  Bench a;
  Bench b;
  feed_mixture(a);
  feed_mixture(b);
  const auto ua = a.all<RangeUse>();
  const auto ub = b.all<RangeUse>();
  ASSERT_EQ(ua.size(), ub.size());
  for (std::size_t i = 0; i < ua.size(); ++i) {
    EXPECT_EQ(ua[i].reason, ub[i].reason);
    EXPECT_EQ(std::bit_cast<std::uint64_t>(ua[i].residual_m),
              std::bit_cast<std::uint64_t>(ub[i].residual_m));
  }
}

TEST(PaperRanges, are_all_answered_by_a_vehicle_with_the_paper_preset) {
  odometry::TestRoom room;
  room.rings = 8;
  room.columns = 200;
  VehicleSettings settings;
  settings.odometry.preset = odometry::Preset::kPaper;
  settings.has_imu = false;
  settings.calibration.T_body_lidar = room.T_body_lidar;
  PeerSettings peer;
  peer.id = kPeer;
  peer.antennas_body_m = {Vec3::Zero()};
  peer.prior = PeerPrior{};
  peer.prior->T_self_peer.p = {2.0, 1.0, 0.0};
  settings.peers = {peer};
  Vehicle vehicle(kSelf, settings);
  SerialExecutor executor;
  OutputList out;
  for (int k = 0; k < 6; ++k) {
    const Time t = Time::from_s(0.1 * k + 0.05);
    vehicle.step(PeerStatus{kPeer, t, true}, executor, out);
    RangeSample sample;
    sample.t = t;
    sample.from = kPeer;
    sample.to = kSelf;
    sample.range_m = std::sqrt(5.0);
    vehicle.step(sample, executor, out);
    vehicle.step(std::shared_ptr<const sensor::LidarScan>(room.scan(0.1 * k)), executor, out);
  }
  vehicle.step(EndOfData{}, executor, out);
  int answered = 0;
  int poses = 0;
  for (const Output& o : out) {
    answered += std::holds_alternative<RangeUse>(o) ? 1 : 0;
    poses += std::holds_alternative<PoseEstimate>(o) ? 1 : 0;
  }
  EXPECT_EQ(answered, 6);
  EXPECT_EQ(poses, 6);
}

}  // namespace
}  // namespace rali::vehicle
