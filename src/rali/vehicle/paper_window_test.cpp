#include "rali/vehicle/paper_window.hpp"

#include <gtest/gtest.h>

#include "rali/vehicle/inertial_factor.hpp"
#include "rali/vehicle/peer_places.hpp"

namespace rali::vehicle {
namespace {

using geometry::SE3;
using geometry::Vec3;

PaperWindow::Node node_at(std::uint32_t seq, double x_m) {
  PaperWindow::Node node;
  node.seq = seq;
  node.t = Time::from_s(1.0 * seq);
  node.T_odom_body.p = {x_m, 0.0, 0.0};
  return node;
}

/// One second at constant speed: the accelerometer measures gravity alone.
graph::InertialFactor even_second() {
  imu::Preintegration sum({}, {1e-4, 1e-3});
  for (int k = 0; k < 200; ++k) {
    EXPECT_TRUE(sum.add(Vec3::Zero(), Vec3(0.0, 0.0, 9.81), 0.005));
  }
  return inertial_factor(sum, odometry::ImuNoiseSettings{}, SE3{});
}

// The speed before is 1 +- 0.1 m/s. The corrected step is 1.1 +- 0.05 m and the range 1.1 +- 0.1 m:
// 1 + 0.1 (400 + 100)/(400 + 100 + 100) = 1.0833 m/s. A correction that did not change the speed
// would drift away again until the next keyframe.
TEST(PaperWindow, corrects_velocity_together_with_position) {
  PaperWindow window{ranging::PaperRangeSettings{}};
  PaperWindow::Node first = node_at(0, 0.0);
  first.motion.v_odom_imu_mps = {1.0, 0.0, 0.0};
  window.add(first, true);
  PaperWindow::Node second = node_at(1, 1.0);
  second.motion.v_odom_imu_mps = {1.0, 0.0, 0.0};
  second.inertial = even_second();
  window.add(second, true);
  window.shift_newest({0.1, 0.0, 0.0});
  PaperRangeFactor range;
  range.p_odom_peer_m = {-10.0, 0.0, 0.0};
  range.range_m = 11.1;
  range.t = second.t;
  window.set_range(range);
  window.solve();
  EXPECT_NEAR(window.nodes()[1].motion.v_odom_imu_mps.x(), 1.0833, 2e-3);
  EXPECT_NEAR(window.nodes()[1].T_odom_body.p.x(), 1.0833, 2e-3);
  EXPECT_NEAR(window.nodes()[0].T_odom_body.p.x(), 0.0, 1e-5);
}

/// One step of 1 m along x, degenerate along x, and a range 0.1 m too long in the direction
/// (3, 4)/5 from the peer.
Vec3 pulled_sideways(PaperSteps steps) {
  PaperWindow window{ranging::PaperRangeSettings{}, steps};
  window.add(node_at(0, 0.0), false);
  PaperWindow::Node second = node_at(1, 1.0);
  second.e3_odom = Vec3::UnitX();
  window.add(second, true);
  PaperRangeFactor range;
  range.p_odom_peer_m = {-2.0, -4.0, 0.0};
  range.range_m = 5.1;
  range.t = second.t;
  window.set_range(range);
  window.solve();
  return window.nodes()[1].T_odom_body.p - Vec3::UnitX();
}

// Variances along x 0.05^2, across 0.005^2, of the range 0.1^2: S = 0.36 * 25e-4 + 0.64 * 25e-6 +
// 0.01 = 0.010916; x takes 0.6 * 25e-4 / S of 0.1 m, y takes 0.8 * 25e-6 / S.
TEST(PaperWindow, shifts_only_along_the_degenerate_direction) {
  const Vec3 moved = pulled_sideways(PaperSteps::kDegenerate);
  EXPECT_NEAR(moved.x(), 0.01374, 2e-4);
  EXPECT_NEAR(moved.y(), 0.00018, 2e-5);
}

// As in the paper: 0.05^2 / (0.05^2 + 0.1^2) of 0.1 m in the direction of the range.
TEST(PaperWindow, shifts_in_all_directions_with_isotropic_steps) {
  const Vec3 moved = pulled_sideways(PaperSteps::kIsotropic);
  EXPECT_NEAR(moved.x(), 0.012, 2e-4);
  EXPECT_NEAR(moved.y(), 0.016, 2e-4);
}

TEST(PaperWindow, moves_nothing_without_ranges) {
  PaperWindow window{ranging::PaperRangeSettings{}};
  window.add(node_at(0, 0.0), true);
  window.add(node_at(1, 1.0), true);
  window.solve();
  EXPECT_EQ(window.nodes()[1].T_odom_body.p, Vec3(1.0, 0.0, 0.0));
}

TEST(PaperWindow, keeps_the_configured_number_of_keyframes) {
  ranging::PaperRangeSettings settings;
  settings.window_keyframes = 3;
  PaperWindow window{settings};
  for (std::uint32_t k = 0; k < 6; ++k) window.add(node_at(k, k), true);
  ASSERT_EQ(window.nodes().size(), 3U);
  EXPECT_EQ(window.nodes().front().seq, 3U);
}

TEST(PaperWindow, distributes_a_second_shift_only_over_keyframes_after_the_first) {
  PaperWindow window{ranging::PaperRangeSettings{}};
  for (std::uint32_t k = 0; k < 5; ++k) {
    window.add(node_at(k, k), true);
    if (k == 2) window.shift_newest({0.4, 0.0, 0.0});
  }
  window.shift_newest({0.0, 0.2, 0.0});
  const auto& nodes = window.nodes();
  EXPECT_NEAR(nodes[1].T_odom_body.p.x(), 1.2, 1e-12);
  EXPECT_NEAR(nodes[2].T_odom_body.p.x(), 2.4, 1e-12);
  EXPECT_EQ(nodes[2].T_odom_body.p.y(), 0.0);
  EXPECT_NEAR(nodes[3].T_odom_body.p.y(), 0.1, 1e-12);
  EXPECT_NEAR(nodes[4].T_odom_body.p.y(), 0.2, 1e-12);
  const Vec3 step = nodes[4].T_previous_this.p;
  EXPECT_LT((step - (nodes[4].T_odom_body.p - nodes[3].T_odom_body.p)).norm(), 1e-12);
}

TEST(PeerPlaces, prior_is_relative_to_the_levelled_first_pose_and_heading) {
  // Heading 90 deg and pitched down by 10 deg: 3 m ahead is along y, at the same height.
  SE3 first;
  first.R = geometry::rotation_from_rpy(0.0, 0.1745, 1.570796);
  first.p = {1.0, 1.0, 0.5};
  PeerWatch peer;
  peer.settings.prior.emplace();
  peer.settings.prior->T_self_peer.p = {3.0, 0.0, 0.0};
  const auto place = place_of(peer, Vec3(0.0, 0.0, 0.4), first, Vec3::UnitZ());
  ASSERT_TRUE(place.has_value());
  EXPECT_LT((place->p_odom_m - Vec3(1.0, 4.0, 0.9)).norm(), 1e-5);
}

TEST(PeerPlaces, a_peer_that_moved_is_at_its_reported_position) {
  // It starts 3 m ahead, turned to the left, and reports a path of 10 m: 10 m to the left of there.
  PeerWatch peer;
  peer.settings.prior.emplace();
  peer.settings.prior->T_self_peer.R = geometry::rotation_from_rpy(0.0, 0.0, 1.570796);
  peer.settings.prior->T_self_peer.p = {3.0, 0.0, 0.0};
  peer.on(PeerStatus{VehicleId{0}, Time::from_s(1.0), false}, 0.1, 1.5);
  peer.moved = true;
  EXPECT_FALSE(place_of(peer, Vec3::Zero(), SE3{}, Vec3::UnitZ())) << "it has said nothing";
  PeerStatus there{VehicleId{0}, Time::from_s(2.0), true, PeerPose{}};
  there.pose->T_start_body.p = {10.0, 0.0, 0.0};
  there.pose->position_covariance_m2 = Vec3(0.04, 0.0, 0.0).asDiagonal();
  peer.on(there, 0.1, 1.5);
  const auto place = place_of(peer, Vec3::Zero(), SE3{}, Vec3::UnitZ());
  ASSERT_TRUE(place.has_value());
  EXPECT_LT((place->p_odom_m - Vec3(3.0, 10.0, 0.0)).norm(), 1e-4);
  // Its own uncertainty along its path is along y here; that of the heading is across the line to
  // it.
  const double arm = peer.settings.prior->sigma_rad;
  const double start = peer.settings.prior->sigma_m;
  EXPECT_NEAR(place->covariance_m2(0, 0), start * start + arm * arm * 100.0, 1e-3);
  EXPECT_NEAR(place->covariance_m2(1, 1), start * start + 0.04 + arm * arm * 9.0, 1e-3);
}

// Its radio was silent while it drove: it only reports to stand, elsewhere.
TEST(PeerPlaces, a_peer_that_stands_elsewhere_after_silence_has_gone) {
  const auto gone = [](double silent_s, double moved_m) {
    PeerWatch peer;
    PeerStatus status{VehicleId{0}, Time::from_s(1.0), true, PeerPose{}};
    peer.on(status, 0.1, 1.5);
    status.t = Time::from_s(1.0 + silent_s);
    status.pose->T_start_body.p.x() = moved_m;
    peer.on(status, 0.1, 1.5);
    return peer.gone && peer.moved;
  };
  EXPECT_TRUE(gone(20.0, 5.0));
  EXPECT_FALSE(gone(20.0, 0.05)) << "noise";
  EXPECT_FALSE(gone(0.1, 5.0)) << "a correction of its pose at standstill";
}

TEST(PeerPlaces, a_peer_status_older_than_1_5_s_is_ignored) {
  PeerWatch peer;
  EXPECT_FALSE(peer.stands_at(Time::from_s(1.0), 1.5));
  peer.on(PeerStatus{VehicleId{0}, Time::from_s(1.0), true}, 0.1, 1.5);
  EXPECT_TRUE(peer.stands_at(Time::from_s(2.0), 1.5));
  EXPECT_FALSE(peer.stands_at(Time::from_s(2.6), 1.5));
  peer.on(PeerStatus{VehicleId{0}, Time::from_s(0.5), false}, 0.1, 1.5);  // late
  EXPECT_TRUE(peer.stands_at(Time::from_s(2.0), 1.5));
  EXPECT_FALSE(peer.moved);
  peer.on(PeerStatus{VehicleId{0}, Time::from_s(2.0), false}, 0.1, 1.5);
  EXPECT_TRUE(peer.moved);
}

}  // namespace
}  // namespace rali::vehicle
