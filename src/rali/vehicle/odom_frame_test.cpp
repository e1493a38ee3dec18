#include "rali/vehicle/odom_frame.hpp"

#include <gtest/gtest.h>

namespace rali::vehicle {
namespace {

using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;

SE3 at(double x_m, double yaw_rad = 0.0) {
  return {geometry::rotation_from_rpy(0.0, 0.0, yaw_rad), Vec3(x_m, 0.0, 0.0)};
}

/// A scan with the inertial prediction `predicted`, after `step`, and the LiDAR result `found`.
odometry::ScanResult scan(const SE3& step, const SE3& predicted, const SE3& found) {
  odometry::ScanResult out;
  out.inertial = true;
  out.T_last_predicted = step;
  out.T_odom_body_predicted = predicted;
  out.T_odom_body = found;
  return out;
}

/// Distance that odom moved beyond the prediction.
double beyond_m(const SE3& before, const SE3& step, const SE3& now) {
  return ((before * step).p - now.p).norm();
}

TEST(OdomFrame, applies_a_small_lidar_correction_at_once) {
  OdomFrame odom;
  odom.follow(scan({}, {}, {}));
  const SE3 now = odom.follow(scan(at(0.1), at(0.1), at(0.12, 0.005)));
  EXPECT_NEAR(now.p.x(), 0.12, 1e-12);
  EXPECT_NEAR(geometry::so3_log(now.R).z(), 0.005, 1e-12);
}

TEST(OdomFrame, spreads_a_large_lidar_correction_over_steps_of_3_cm) {
  OdomFrame odom;
  SE3 before = odom.follow(scan({}, {}, {}));
  SE3 found = at(0.3);  // 0.2 m and 0.04 rad off the prediction
  found.R = geometry::rotation_from_rpy(0.0, 0.0, 0.04);
  SE3 now = odom.follow(scan(at(0.1), at(0.1), found));
  EXPECT_LE(beyond_m(before, at(0.1), now), 0.03 + 1e-12);
  for (int k = 0; k < 8; ++k) {
    before = now;
    now = odom.follow(scan({}, found, found));
    EXPECT_LE(beyond_m(before, {}, now), 0.03 + 1e-12) << k;
  }
  EXPECT_NEAR(now.p.x(), 0.3, 1e-12);
  EXPECT_NEAR(geometry::so3_log(now.R).z(), 0.04, 1e-12);
}

TEST(OdomFrame, is_not_shifted_by_a_range_update_of_the_local_pose) {
  OdomFrame odom;
  odom.follow(scan({}, {}, {}));
  odom.follow(scan(at(0.1), at(0.1), at(0.1)));
  // A range shifted the pose 5 m ahead; the LiDAR agrees with the prediction from there.
  const SE3 now = odom.follow(scan(at(0.1), at(5.2), at(5.2)));
  EXPECT_NEAR(now.p.x(), 0.2, 1e-12);
}

/// The same of a vehicle without inertial data, `t_s` after the first scan.
odometry::ScanResult alone(double t_s, const SE3& step, const SE3& predicted, const SE3& found) {
  odometry::ScanResult out = scan(step, predicted, found);
  out.t = Time::from_s(100.0 + t_s);
  out.inertial = false;
  out.state = odometry::TrackState::kGood;
  return out;
}

TEST(OdomFrame, without_inertial_data_spreads_a_jump_over_steps_of_3_cm) {
  OdomFrame odom;
  SE3 before = odom.follow(alone(0.0, {}, {}, {}));
  const SE3 found = at(1.5, 0.4);
  SE3 now = odom.follow(alone(0.1, at(0.1), at(0.1), found));
  EXPECT_NEAR(beyond_m(before, at(0.1), now), 0.03, 1e-12);
  for (int k = 2; k < 60; ++k) {
    before = now;
    now = odom.follow(alone(0.1 * k, {}, found, found));
    EXPECT_LE(beyond_m(before, {}, now), 0.03 + 1e-12) << k;
  }
  EXPECT_NEAR(now.p.x(), 1.5, 1e-9);
  EXPECT_NEAR(geometry::so3_log(now.R).z(), 0.4, 1e-9);
}

// A hand-held sensor at two scans a second: constant velocity is off by decimetres and by half a
// radian, differently in each scan. Corrections of three centimetres would leave odom metres behind
// in seconds.
TEST(OdomFrame, at_2_hz_takes_a_feasible_acceleration_as_motion) {
  OdomFrame odom;
  odom.follow(alone(0.0, {}, {}, {}));
  const SE3 now = odom.follow(alone(0.5, at(0.5), at(0.5), at(0.8, 0.5)));
  EXPECT_NEAR(now.p.x(), 0.8, 1e-12);
  EXPECT_NEAR(geometry::so3_log(now.R).z(), 0.5, 1e-12);
  // Larger corrections are taken in steps, and a longer gap allows no larger ones.
  const SE3 far = odom.follow(alone(3.0, {}, now, at(5.8)));
  EXPECT_NEAR((far.p - now.p).norm(), 0.75, 1e-9);
}

TEST(OdomFrame, continues_from_its_last_pose_when_a_lost_map_restarts) {
  OdomFrame odom;
  odom.follow(alone(0.0, {}, {}, {}));
  const SE3 before = odom.follow(alone(0.1, at(0.1), at(0.1), at(0.1)));
  odometry::ScanResult lost = alone(0.2, at(4.0), at(4.1), at(-3.0));
  lost.state = odometry::TrackState::kDiverged;
  lost.new_map = true;
  EXPECT_EQ(odom.follow(lost).p, before.p);
  const SE3 after = odom.follow(alone(0.3, at(0.1), at(-2.9), at(-2.9)));
  EXPECT_NEAR(after.p.x(), 0.2, 1e-12) << "nothing of the jump is made good later";
}

TEST(OdomFrame, covariance_includes_the_correction_not_yet_applied) {
  const Mat6 local = 1e-4 * Mat6::Identity();
  const Mat6 P = odom_covariance(local, at(5.0), at(3.0));
  EXPECT_NEAR(P(3, 3), 4.0 + 1e-4, 1e-9);
  EXPECT_NEAR(P(4, 4), 1e-4, 1e-12);
}

}  // namespace
}  // namespace rali::vehicle
