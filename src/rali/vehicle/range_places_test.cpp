#include <gtest/gtest.h>

#include "rali/vehicle/staged_for_test.hpp"

namespace rali::vehicle {
namespace {

using geometry::Vec3;

// In a column every vehicle sees the others keep their distance: taken for walls, they said that
// nobody moved. The odometry of one lost 6 m of 22.
TEST(RangeStage, who_drives_is_where_it_says_unless_it_is_late_or_in_doubt) {
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
}

// Who has told nobody where it starts is at some distance all the same.
TEST(RangeStage, who_is_heard_without_a_known_place_is_so_far_away) {
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

/// Variance of the own place along x after a range to a peer that has moved and says where to.
double own_variance_m2(const std::optional<Vec3>& blind_axis) {
  Staged s;
  s.filter.axis = blind_axis;
  s.run(0.0);
  PeerPose pose;
  pose.T_start_body.p = Vec3(2.0, 0.0, 0.0);
  s.stage.on(PeerStatus{kPeer, Time::from_s(0.5), false, pose});
  s.stage.on(PeerStatus{kPeer, Time::from_s(1.0), true, pose});
  const bool used = s.one(1.0, 11.0).used();
  return used ? s.filter.position_covariance()(0, 0) : 0.0;
}

// What it says it knows by ranges to this vehicle, among others: four in a column, each sure of the
// others, stated 0.2 m and were 1.6 m off.
TEST(RangeStage, a_peer_that_has_moved_is_no_second_opinion_of_a_blind_way) {
  EXPECT_GT(own_variance_m2(Vec3(Vec3::UnitX())), 0.0399) << "0.2 m, as before";
  EXPECT_LT(own_variance_m2(std::nullopt), 0.03);
  EXPECT_GT(own_variance_m2(std::nullopt), 0.01) << "the range was used";
  EXPECT_LT(own_variance_m2(Vec3(Vec3::UnitY())), 0.03) << "blind in another direction";
}

}  // namespace
}  // namespace rali::vehicle
