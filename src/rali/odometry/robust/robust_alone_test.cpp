#include <memory>

#include <gtest/gtest.h>

#include "rali/base/executor.hpp"
#include "rali/odometry/robust/robust_odometry.hpp"
#include "rali/odometry/robust/rooms_for_test.hpp"

namespace rali::odometry {
namespace {

using geometry::SE3;

constexpr double kDegree = std::numbers::pi / 180.0;

/// LiDAR alone, twice a second.
class Alone {
 public:
  ScanResult see(const test::Rooms& rooms, double x, double y, double yaw_rad) {
    t_ = t_ + Duration::from_s(0.5);
    return odometry_->process(test::seen_from(rooms, x, y, yaw_rad, t_), executor_, findings);
  }

  FindingList findings;

 private:
  SerialExecutor executor_;
  Time t_ = Time::from_s(100.0);
  std::unique_ptr<Odometry> odometry_ = make_robust_odometry({}, {}, false);
};

double apart_m(const SE3& a, const SE3& b) { return (a.p - b.p).norm(); }

double apart_deg(const SE3& a, const SE3& b) {
  return geometry::so3_log(a.R.transpose() * b.R).norm() / kDegree;
}

TEST(RobustAlone, finds_the_pose_after_a_75_degree_turn_from_standstill) {
  Alone alone;
  const test::Rooms rooms = test::two_rooms();
  const SE3 T_world_odom = test::upright_pose(-2.0, 0.0, 0.0);
  for (int k = 0; k < 4; ++k)
    ASSERT_LT(apart_m(alone.see(rooms, -2.0, 0.0, 0.0).T_odom_body, {}), 0.02);
  const ScanResult turned = alone.see(rooms, -1.6, 0.3, 75.0 * kDegree);
  const SE3 T_true = T_world_odom.inverse() * test::upright_pose(-1.6, 0.3, 75.0 * kDegree);
  EXPECT_EQ(turned.state, TrackState::kGood);
  EXPECT_LT(apart_m(turned.T_odom_body, T_true), 0.05);
  EXPECT_LT(apart_deg(turned.T_odom_body, T_true), 1.0);
  EXPECT_TRUE(alone.findings.empty());
}

TEST(RobustAlone, reports_divergence_on_a_scan_of_another_room) {
  Alone alone;
  const test::Rooms rooms = test::two_rooms();
  for (int k = 0; k < 4; ++k) alone.see(rooms, -2.0, 0.0, 0.0);
  const ScanResult other = alone.see(test::hall(), 0.0, 0.0, 0.3);
  EXPECT_EQ(other.state, TrackState::kDiverged);
  EXPECT_GT(other.covariance.diagonal().tail<3>().maxCoeff(), 1.0);
  EXPECT_EQ(other.keyframe, nullptr);
  ASSERT_EQ(alone.findings.size(), 1U);
  EXPECT_EQ(alone.findings.front().id, "odometry.diverged");
  EXPECT_EQ(alone.findings.front().t, Time::from_s(102.0));
  EXPECT_EQ(alone.findings.front().t_end, Time::from_s(102.5));
}

TEST(RobustAlone, relocalises_in_the_map_after_one_diverged_scan) {
  Alone alone;
  const test::Rooms rooms = test::two_rooms();
  for (int k = 0; k < 4; ++k) alone.see(rooms, -2.0, 0.0, 0.0);
  alone.see(test::hall(), 0.0, 0.0, 0.3);
  const ScanResult back = alone.see(rooms, -1.7, 0.0, 20.0 * kDegree);
  EXPECT_EQ(back.state, TrackState::kGood);
  EXPECT_LT(apart_m(back.T_odom_body, {geometry::Mat3::Identity(), {0.3, 0.0, 0.0}}), 0.05);
}

}  // namespace
}  // namespace rali::odometry
