#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "rali/ranging/path_fit.hpp"
#include "rali/vehicle/staged_for_test.hpp"

namespace rali::vehicle {
namespace {

using geometry::Mat3;
using geometry::Vec3;

/// A vehicle at standstill at odom's origin in a tunnel along x, and a peer at standstill 0.4 m
/// behind it and 1.2 m to its left, before or after passing it. The peer's start was measured 10 m
/// ahead; its reported path is 0.1 m too long, with a sigma of 0.5 m.
struct Beside {
  static constexpr double kRange_m = 1.2649;  ///< of 0.4 m and 1.2 m
  double yaw_rad = 0.0;                       ///< of the peer's start
  bool at_rest = true;
  double range_m = kRange_m;
  SeenPeer me{kSelf, 0, Vec3(0.4, -1.2, 0.0), 0.01 * Mat3::Identity()};
  bool says = true;

  /// The filter after two ranges at standstill of both.
  [[nodiscard]] odometry::DenseAugmentedFilter after() const {
    VehicleSettings settings = settings_with_prior();
    const Mat3 R = geometry::rotation_from_rpy(0.0, 0.0, yaw_rad);
    settings.peers[0].prior->T_self_peer.R = R;
    Staged s(settings);
    s.filter.axis = Vec3::UnitX();
    s.filter.now.v_odom_mps.setZero();
    s.filter.now.at_rest = at_rest;
    s.run(0.0);
    PeerPose pose;
    pose.T_start_body.p = R.transpose() * Vec3(-10.5, 0.0, 0.0);
    pose.position_covariance_m2 = 0.25 * Mat3::Identity();
    s.stage.on(PeerStatus{kPeer, Time::from_s(0.5), false, pose});
    SeenPeer seen = me;
    seen.apart_start_m = R.transpose() * me.apart_start_m;
    if (says) pose.seen = {seen};
    s.stage.on(PeerStatus{kPeer, Time::from_s(1.0), true, pose});
    static_cast<void>(s.one(1.0, range_m));
    static_cast<void>(s.one(1.1, range_m));
    return s.filter;
  }

  [[nodiscard]] bool placed() const { return after().augmented().size() > 0; }
};

// 1.3 m beside the anchor neither range nor reported path separates ahead from behind: no range was
// used, and rounds ended before any vehicle had moved.
TEST(RangeSeen, initialises_the_landmark_from_the_position_reported_by_the_peer) {
  for (const double yaw_rad : {0.0, 2.0, std::numbers::pi}) {
    const odometry::DenseAugmentedFilter filter = Beside{.yaw_rad = yaw_rad}.after();
    ASSERT_GE(filter.augmented().size(), 3) << yaw_rad;
    EXPECT_LT((filter.augmented().mean.head<3>() - Vec3(-0.4, 1.2, 0.0)).norm(), 0.02) << yaw_rad;
    const double sigma_m = std::sqrt(filter.augmented().covariance(0, 0));
    EXPECT_GT(sigma_m, 0.1) << "at least as much as the other says";
    EXPECT_LT(sigma_m, 0.35) << "and with the own doubt about the way, 0.2 m";
  }
  EXPECT_FALSE((Beside{.says = false}.placed())) << "by its way alone it may be on either side";
}

// The bias of this pair is in the peer's report, too: without its variance, both would be
// overconfident in a position 0.1 m off.
TEST(RangeSeen, landmark_distance_sigma_includes_the_bias_of_the_pair) {
  Beside s;
  s.me.covariance_m2 = 1e-6 * Mat3::Identity();
  const odometry::DenseAugmentedFilter filter = s.after();
  ASSERT_GE(filter.augmented().size(), 3);
  const Vec3 e = Vec3(-0.4, 1.2, 0.0).normalized();
  Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(filter.P.cols());
  row.segment<3>(3) = -e;
  row.segment<3>(odometry::DenseAugmentedFilter::kOwn) = e;
  const double apart_sigma_m = std::sqrt((row * filter.P * row.transpose()).value());
  const double bias_sigma_m = ranging::bias_sigma_m(VehicleSettings{}.ranging.bias, false);
  EXPECT_GT(apart_sigma_m, 0.6 * bias_sigma_m) << "shared with the bias by the first ranges";
}

// In a tunnel, relative heights have a sigma of half a metre, which is enough. The report was
// refused for that, and the mission ended 4 m beside the anchor.
TEST(RangeSeen, accepts_a_large_height_sigma_but_not_a_large_horizontal_one) {
  Beside s;
  s.me.covariance_m2(2, 2) = 0.25;
  EXPECT_TRUE(s.placed());
  s.me.covariance_m2(1, 1) = 0.25;
  EXPECT_FALSE(s.placed());
}

TEST(RangeSeen, rejects_reports_that_are_uncertain_invalid_or_contradict_the_range) {
  EXPECT_TRUE(Beside{}.placed());
  EXPECT_FALSE((Beside{.at_rest = false}.placed())) << "where it was then it is not now";
  EXPECT_FALSE((Beside{.range_m = 3.0}.placed()));
  Beside doubtful;
  doubtful.me.covariance_m2 = Mat3::Identity();
  EXPECT_FALSE(doubtful.placed());
  Beside stranger;
  stranger.me.vehicle = VehicleId{7};
  EXPECT_FALSE(stranger.placed());
  Beside antenna;
  antenna.me.antenna = 9;
  EXPECT_FALSE(antenna.placed());
  Beside broken;
  broken.me.apart_start_m.x() = std::nan("");
  EXPECT_FALSE(broken.placed());
}

}  // namespace
}  // namespace rali::vehicle
