#include <cmath>

#include <gtest/gtest.h>

#include "rali/vehicle/paper_ranges_for_test.hpp"

namespace rali::vehicle {
namespace {

using geometry::Vec3;
using odometry::KeyframeMove;
using ranging::RangeUse;

/// Ranges 0.25 m too long: twelve metres where the LiDAR is not degenerate, then the corridor.
std::optional<KeyframeMove> after_known_places(Bench& b) {
  b.settings.ranging.paper.gap_m = 0.1;
  b.seen = &kRoom;
  b.begin();
  double t_s = 0.1;
  for (double x = 2.0; x < 15.0; x += 2.0, t_s += 1.0) {
    b.ranges(t_s + 0.05, t_s + 1.0, std::hypot(x, 1.0) + 0.25);
    static_cast<void>(b.scan(t_s + 1.0, {x, 0.0, 0.0}));
  }
  b.seen = &kCorridor;
  b.ranges(t_s + 0.05, t_s + 1.0, std::hypot(16.0, 1.0) + 0.25);
  const auto move = b.scan(t_s + 1.0, {16.0, 0.0, 0.0});
  b.stage->flush(b.out);
  return move;
}

// All from one side, so that 0.25 m are divided by the variances of position (0.2 m) and constant
// (0.1 m): a fifth of it is the constant. Both together fit, and nothing is corrected.
TEST(PaperRanges, calibrate_the_pair_bias_without_degeneracy) {
  Bench b;
  EXPECT_FALSE(after_known_places(b));
  EXPECT_NEAR(b.all<RangeUse>().back().bias_m, 0.05, 0.01);
}

TEST(PaperRanges, are_used_without_bias_calibration_in_literal_mode) {
  Bench b;
  b.settings.odometry.paper.literal = true;
  const auto move = after_known_places(b);
  ASSERT_TRUE(move);
  EXPECT_GT(move->T_odom_body.p.x(), 16.1);
}

// The first scan that is not degenerate has a position that depends on the prediction before it.
TEST(PaperRanges, correct_the_first_keyframe_after_a_degenerate_stretch_and_no_later_one) {
  Bench b;
  b.begin();
  b.seen = &kRoom;
  b.ranges(0.15, 1.1, 20.5);
  const auto move = b.scan(1.1, {20.0, 0.0, 0.0});
  ASSERT_TRUE(move);
  EXPECT_NEAR(move->T_odom_body.p.x(), 20.0 + kShift, 1e-5);
  b.ranges(1.15, 2.1, 21.5);
  EXPECT_FALSE(b.scan(2.1, {20.0, 0.0, 0.0}));
}

// The peer stops 0.3 m farther away than it reported. That is its error, not the own one.
TEST(PaperRanges, between_two_standing_vehicles_correct_the_peer_position) {
  Bench b;
  b.settings.ranging.paper.gap_m = 0.1;
  b.p_peer = {-10.0, 0.0, 0.0};
  b.begin();
  b.at_rest = true;
  b.ranges(0.15, 1.1, 10.3);
  EXPECT_FALSE(b.scan(1.1, Vec3::Zero()));
  b.at_rest = false;
  b.ranges(1.15, 2.1, 15.3);
  EXPECT_FALSE(b.scan(2.1, {5.0, 0.0, 0.0}));
}

}  // namespace
}  // namespace rali::vehicle
