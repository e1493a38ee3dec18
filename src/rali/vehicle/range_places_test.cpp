#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "rali/vehicle/staged_for_test.hpp"

namespace rali::vehicle {
namespace {

using geometry::Vec3;

// In a column, vehicles keep their distances to each other: taken for walls, they cancelled the
// motion. The odometry of one lost 6 m of 22.
TEST(RangeStage, uses_the_reported_position_of_a_peer_unless_old_or_uncertain) {
  Staged s;
  s.run(0.0);
  const auto places = [&s](double t_s, double sigma_max_m) {
    return s.stage.places(s.filter, Time::from_s(t_s), sigma_max_m);
  };
  PeerPose pose;
  pose.T_start_body.p = Vec3(2.0, 0.5, 0.0);
  s.stage.on(PeerStatus{kPeer, Time::from_s(1.0), false, pose});
  ASSERT_EQ(places(1.0, 0.7).size(), 1U);
  EXPECT_LT((places(1.0, 0.7)[0].p_odom_m - Vec3(12.0, 0.5, 0.0)).norm(), 1e-9);
  EXPECT_TRUE(places(1.0, 0.6).empty()) << "0.2 m, and 0.05 rad over 12 m: 0.63 m across";
  EXPECT_TRUE(places(4.0, 0.7).empty()) << "what it said three seconds ago";
  pose.position_covariance_m2 = geometry::Mat3::Identity();
  s.stage.on(PeerStatus{kPeer, Time::from_s(1.1), false, pose});
  EXPECT_TRUE(places(1.1, 0.7).empty()) << "it does not know itself";
  s.stage.on(PeerStatus{kPeer, Time::from_s(1.2), false});
  EXPECT_TRUE(places(1.2, 0.7).empty()) << "it says nothing";
  const double nan = std::nan("");
  for (const bool walls : {false, true}) {
    PeerPose broken;
    (walls ? broken.walls.emplace().left_m : broken.T_start_body.p.y()) = nan;
    s.stage.on(PeerStatus{kPeer, Time::from_s(1.3), false, broken});
    EXPECT_TRUE(places(1.3, 100.0).empty()) << "nothing that could be used";
  }
}

// A peer of unknown start pose still has a range.
TEST(RangeStage, gives_the_latest_range_to_a_peer_without_known_position) {
  Staged s;
  s.run(0.0);
  const auto unplaced = [&s](double t_s) {
    return s.stage.unplaced(s.filter, Time::from_s(t_s), 0.7);
  };
  EXPECT_TRUE(unplaced(0.0).empty()) << "nothing was heard";
  s.stage.on(PeerStatus{kPeer, Time::from_s(1.0), false});
  s.one(1.0, 4.2);
  ASSERT_EQ(unplaced(1.1).size(), 1U);
  EXPECT_EQ(unplaced(1.1)[0].range_m, 4.2);
  EXPECT_TRUE(unplaced(4.0).empty()) << "three seconds ago";
  PeerPose pose;
  pose.T_start_body.p = Vec3(2.0, 0.5, 0.0);
  s.stage.on(PeerStatus{kPeer, Time::from_s(1.1), false, pose});
  EXPECT_TRUE(unplaced(1.1).empty()) << "it says where it is";
}

/// A peer that reports a path of path_m along x from its start, and standstill there; the vehicle
/// is 1 m along x from its own start.
struct Moved : Staged {
  Moved(double path_m, double sigma_m, const std::optional<Vec3>& degenerate_axis,
        const VehicleSettings& settings = settings_with_prior())
      : Staged(settings) {
    filter.axis = degenerate_axis;
    run(0.0);
    PeerPose pose;
    pose.T_start_body.p = Vec3(path_m, 0.0, 0.0);
    pose.position_covariance_m2 = sigma_m * sigma_m * geometry::Mat3::Identity();
    stage.on(PeerStatus{kPeer, Time::from_s(0.5), false, pose});
    stage.on(PeerStatus{kPeer, Time::from_s(1.0), true, pose});
  }

  /// Ranges at 10 Hz to a peer at standstill at x_m. @return how many were used
  int receive(double x_m, int ranges) {
    int used = 0;
    for (int k = 0; k < ranges; ++k) {
      const double t_s = 1.0 + 0.1 * k;
      used += one(t_s, std::abs(x_m - t_s)).used() ? 1 : 0;
    }
    return used;
  }

  [[nodiscard]] double own_variance_m2() const { return filter.position_covariance()(0, 0); }
};

// The peer is located by ranges to this vehicle, among others: four in a column that treated
// such reports as independent stated 0.2 m and were 1.6 m off. And a landmark shares the error
// of the own position from which it was initialised: without that each new one halved the
// uncertainty of the position, and vehicles stated 1 m that were 20 m off.
TEST(RangeStage, a_moved_peer_does_not_reduce_variance_along_a_degenerate_direction) {
  Moved degenerate(2.0, 0.0, Vec3::UnitX());
  EXPECT_EQ(degenerate.receive(12.0, 6), 5) << "the first is alone: it may be wild";
  EXPECT_NEAR(degenerate.own_variance_m2(), 0.04, 1e-4) << "as before";
  Moved seeing(2.0, 0.0, std::nullopt);
  EXPECT_EQ(seeing.receive(12.0, 1), 1);
  EXPECT_LT(seeing.own_variance_m2(), 0.03);
  EXPECT_GT(seeing.own_variance_m2(), 0.01);
  Moved lateral(2.0, 0.0, Vec3::UnitY());
  EXPECT_EQ(lateral.receive(12.0, 1), 0) << "its range is not along the blind way";
}

TEST(RangeStage, uses_the_report_of_a_moved_peer_only_for_ahead_or_behind) {
  const auto place_m = [](double reported_m, double sigma_m, double range_m) {
    Moved m(reported_m, sigma_m, Vec3::UnitX());
    static_cast<void>(m.one(1.0, range_m));
    EXPECT_EQ(m.filter.augmented().size(), 0) << "one range alone may be wild";
    m.filter.now.v_odom_mps.setZero();
    static_cast<void>(m.one(1.1, range_m));
    return m.filter.augmented().size() > 0 ? m.filter.augmented().mean[0] : std::nan("");
  };
  // Within the lateral bound of the passage: 3 m at 20 m, where it would be 0.2 m nearer.
  constexpr double kNear_m = 0.3;
  // It reports 10 m from its start, which is 10 m ahead of the own: 20.
  EXPECT_NEAR(place_m(10.0, 2.0, 19.0), 20.0, kNear_m);
  EXPECT_NEAR(place_m(13.0, 2.0, 19.0), 20.0, kNear_m) << "3 m off is not told";
  EXPECT_NEAR(place_m(-30.0, 2.0, 21.0), -20.0, kNear_m) << "behind";
  EXPECT_TRUE(std::isnan(place_m(20.0, 2.0, 19.0))) << "its word and the range are 10 m apart";
  EXPECT_TRUE(std::isnan(place_m(-8.0, 20.0, 3.0))) << "on either side";
  EXPECT_NEAR(place_m(-7.0, 0.1, 2.0), 3.0, kNear_m) << "near by, but it says how far aside";
  EXPECT_TRUE(std::isnan(place_m(-7.0, 1.5, 2.0))) << "and here it does not know";
}

// At short range, a lateral offset shortens the distance ahead: a sigma of 2 m instead of 0.6 m
// carried a whole fleet forward by 0.05 m in each leap of 12 m.
TEST(RangeStage, initialises_a_peer_in_a_passage_between_the_observed_walls) {
  const auto lateral = [](const std::vector<double>& walls_y_m) {
    Moved m(10.0, 3.0, Vec3::UnitX());
    m.filter.walls_y_m = walls_y_m;
    m.filter.now.v_odom_mps.setZero();
    static_cast<void>(m.one(1.0, 19.0));
    static_cast<void>(m.one(1.1, 19.0));
    EXPECT_EQ(m.filter.augmented().size(), 5);
    return std::pair(m.filter.augmented().mean[1],
                     std::sqrt(m.filter.augmented().covariance(1, 1)));
  };
  const auto [middle_m, wide_m] = lateral({});
  EXPECT_NEAR(middle_m, 0.0, 0.05);
  EXPECT_GT(wide_m, 1.7);
  // 3 m to the left and 1 m to the right: its middle is 1 m to the left.
  const auto [left_m, narrow_m] = lateral({3.0, -1.0});
  EXPECT_GT(left_m, 0.4);
  EXPECT_LT(left_m, 1.0);
  EXPECT_LT(narrow_m, wide_m - 0.2);
  const auto [one_m, one_wide_m] = lateral({3.0});
  EXPECT_NEAR(one_m, 0.0, 0.05) << "one wall is no passage";
  EXPECT_NEAR(one_wide_m, wide_m, 0.01);
}

// Each vehicle measures its walls by its own LiDAR, to centimetres; by the own walls alone, the
// other may be anywhere between them.
TEST(RangeStage, wall_distances_of_both_vehicles_give_their_lateral_offset) {
  const auto lateral = [](const std::optional<ranging::PassageWalls>& reported, double yaw_rad) {
    VehicleSettings settings = settings_with_prior();
    settings.peers[0].prior->T_self_peer.R = geometry::rotation_from_rpy(0.0, 0.0, yaw_rad);
    Moved m(std::cos(yaw_rad) * -4.0, 1.0, Vec3::UnitX(), settings);
    m.filter.walls_y_m = {3.0, -1.0};
    m.filter.now.v_odom_mps.setZero();
    PeerPose pose;
    pose.T_start_body.p = Vec3(std::cos(yaw_rad) * -4.0, 0.0, 0.0);
    pose.position_covariance_m2 = geometry::Mat3::Identity();
    pose.walls = reported;
    m.stage.on(PeerStatus{kPeer, Time::from_s(1.0), true, pose});
    static_cast<void>(m.one(1.0, 5.0));
    static_cast<void>(m.one(1.1, 5.0));
    EXPECT_EQ(m.filter.augmented().size(), 5);
    return std::pair(m.filter.augmented().mean[1],
                     std::sqrt(m.filter.augmented().covariance(1, 1)));
  };
  // The own position is 1 m to the right of the middle, the other's 0.5 m to the left of it.
  const auto [both_m, both_sigma_m] = lateral(ranging::PassageWalls{Vec3::UnitX(), 1.5, 2.5}, 0.0);
  EXPECT_NEAR(both_m, 1.5, 0.1);
  EXPECT_LT(both_sigma_m, 0.25) << "0.1 m, and 0.125 m for a bend";
  const auto [turned_m, turned_sigma_m] =
      lateral(ranging::PassageWalls{Vec3::UnitX(), 2.5, 1.5}, std::numbers::pi);
  EXPECT_NEAR(turned_m, 1.5, 0.1) << "it began facing this vehicle: its right is left here";
  EXPECT_NEAR(turned_sigma_m, both_sigma_m, 0.02);
  const auto [own_m, own_sigma_m] = lateral(std::nullopt, 0.0);
  EXPECT_GT(own_sigma_m, 0.6) << "it tells of no walls";
  EXPECT_NEAR(own_m, 0.7, 0.3);
  const auto [across_m, across_sigma_m] =
      lateral(ranging::PassageWalls{Vec3::UnitY(), 1.5, 2.5}, 0.0);
  EXPECT_EQ(across_sigma_m, own_sigma_m) << "it stands in another passage";
  EXPECT_EQ(across_m, own_m);
}

/// A passage of 4 m, the vehicle in its middle; the peer is at standstill at its start, which was
/// measured by hand.
struct InPassage : Staged {
  explicit InPassage(double ahead_m) : Staged(ahead(ahead_m)) {
    filter.axis = Vec3::UnitX();
    filter.walls_y_m = {2.0, -2.0};
    run(0.0);
  }

  static VehicleSettings ahead(double ahead_m) {
    VehicleSettings settings = settings_with_prior();
    settings.peers[0].prior->T_self_peer.p = Vec3(ahead_m, 0.0, 0.0);
    return settings;
  }

  /// Lateral offset of the peer, and its sigma, after it reported its walls.
  std::pair<double, double> receive(double t_s, double range_m, double left_m, double right_m) {
    PeerPose pose;
    pose.walls = ranging::PassageWalls{Vec3::UnitX(), left_m, right_m};
    stage.on(PeerStatus{kPeer, Time::from_s(t_s), true, pose});
    static_cast<void>(one(t_s, range_m));
    return {filter.augmented().mean[1], std::sqrt(filter.augmented().covariance(1, 1))};
  }
};

TEST(RangeStage, wall_distances_correct_a_start_pose_again_at_closer_range) {
  InPassage s(9.0);
  // Sigma 0.49 by hand (0.2, and 0.05 rad over 9 m); 0.1 and 0.4 m of bend by walls.
  const auto [far_m, far_sigma_m] = s.receive(0.1, 8.9, 1.7, 2.3);
  EXPECT_NEAR(far_m, 0.3 * 0.49 * 0.49 / (0.49 * 0.49 + 0.5 * 0.5), 0.03);
  EXPECT_NEAR(s.receive(1.0, 8.0, 1.7, 2.3).first, far_m, 0.01) << "the same walls, the same error";
  const auto [near_m, near_sigma_m] = s.receive(6.0, 3.0, 1.7, 2.3);
  EXPECT_NEAR(near_m, 0.3, 0.06);
  EXPECT_LT(near_sigma_m, 0.5 * far_sigma_m);
}

// A hole in the map beside the peer made its passage 2 m wider than here. That was used with a
// sigma of 1 m, and again with each range: after seconds the landmark was half a metre off, by
// seven sigma, and with it the bias of the pair. Each leap past the peer added twice that.
TEST(RangeStage, unequal_wall_distances_are_applied_once) {
  InPassage s(3.0);
  const auto [once_m, once_sigma_m] = s.receive(0.1, 2.9, 1.7, 4.3);
  EXPECT_GT(once_m, 0.02) << "1.3 m aside, sigma 1.1; 0.25 by hand";
  EXPECT_LT(once_m, 0.15);
  for (int k = 1; k < 60; ++k) static_cast<void>(s.receive(0.1 + 0.05 * k, 2.9, 1.7, 4.3));
  const auto [often_m, often_sigma_m] = s.receive(3.2, 2.9, 1.7, 4.3);
  EXPECT_NEAR(often_m, once_m, 0.02);
  EXPECT_NEAR(often_sigma_m, once_sigma_m, 0.02);
  EXPECT_NEAR(s.receive(3.3, 2.9, 1.7, 2.3).first, 0.3, 0.1) << "the hole is closed";
}

TEST(RangeStage, wall_distances_5_sigma_off_are_rejected) {
  // Sigma 0.25 by hand, 0.15 by walls: a lateral offset of 1.6 m would be 5 sigma off.
  EXPECT_NEAR(InPassage(3.0).receive(0.1, 2.9, 0.4, 3.6).first, 0.0, 1e-6);
  EXPECT_NEAR(InPassage(3.0).receive(0.1, 2.9, 1.7, 2.3).first, 0.22, 0.03);
}

// A mixture has room for four pairs: the covariance of a fifth was written beyond its matrix.
TEST(RangeStage, with_six_antennas_in_a_passage_uses_at_least_four) {
  VehicleSettings settings = settings_with_prior();
  settings.antennas_body_m.assign(6, Vec3::Zero());
  Staged s(settings);
  s.filter.axis = Vec3::UnitX();
  s.run(0.0);
  for (int k = 0; k < 24; ++k) {
    const double t_s = 0.1 + 0.05 * k;
    s.report(t_s, true);
    sensor::RangeSample sample = Staged::sample(t_s, 10.0 - t_s);
    sample.from_antenna = static_cast<std::uint8_t>(k % 6);
    s.stage.add(sample, s.out);
    s.run(t_s);
  }
  const auto uses = s.uses();
  const auto used = std::count_if(uses.begin(), uses.end(), [](const auto& u) { return u.used(); });
  EXPECT_GE(used, 16) << "those of four antennas at least";
  EXPECT_TRUE(s.filter.P.allFinite());
}

// A landmark shares the error of the own position from which it was initialised: both move
// together, and the mask has their relative position however long the path was.
TEST(RangeStage, a_landmark_stays_certain_relative_to_an_uncertain_own_pose) {
  Moved m(2.0, 2.0, Vec3::UnitX());
  m.filter.P(3, 3) = 25.0;
  EXPECT_EQ(m.receive(12.0, 6), 5);
  EXPECT_NEAR(m.own_variance_m2(), 25.0, 1e-3);
  EXPECT_FALSE(m.stage.places(m.filter, Time::from_s(1.5), 3.0).empty());
  EXPECT_LT(m.stage.places(m.filter, Time::from_s(1.5), 3.0)[0].covariance_m2(0, 0), 0.5);
}

}  // namespace
}  // namespace rali::vehicle
