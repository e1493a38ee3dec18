#include "rali/odometry/robust/robust_odometry.hpp"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "rali/odometry/make_odometry.hpp"
#include "rali/odometry/robust/driven_for_test.hpp"
#include "rali/odometry/room_for_test.hpp"

namespace rali::odometry {
namespace {

using geometry::SE3;
using geometry::Vec3;
using geometry::Vec6;

struct DriveLog {
  double final_error_m = 0.0;
  double worst_error_m = 0.0;
  double final_error_rad = 0.0;
  double gravity_error_rad = 0.0;
  std::vector<ScanResult> results;
  FindingList findings;
  std::uint64_t hash = 0;
};

/// Drives through the room; odom starts at the body's pose at the end of the first scan.
/// @param yaw_off_deg by which the given mounting of the LiDAR is wrong
DriveLog drive(TestRoom& room, double duration_s, bool has_imu, double yaw_off_deg = 0.0) {
  sensor::Calibration calibration;
  calibration.T_body_lidar = room.T_body_lidar;
  calibration.T_body_lidar.R =
      geometry::rotation_from_rpy(0.0, 0.0, yaw_off_deg * M_PI / 180.0) * room.T_body_lidar.R;
  calibration.T_body_imu = room.T_body_imu;
  const auto odometry = make_odometry(OdometrySettings{}, calibration, has_imu);
  SerialExecutor executor;
  DriveLog run;
  SE3 T_world_odom;
  int imu_index = 0;
  for (int k = 0; 0.1 * (k + 1) <= duration_s + 1e-9; ++k) {
    const auto scan = room.scan(0.1 * k);
    for (; has_imu && 0.005 * imu_index <= 0.1 * (k + 1); ++imu_index) {
      odometry->add_imu(room.imu(0.005 * imu_index));
    }
    const ScanResult result = odometry->process(*scan, executor, run.findings);
    const SE3 truth = room.pose(scan->t_end.s());
    if (k == 0) T_world_odom = truth * result.T_odom_body.inverse();
    const Vec6 error = geometry::boxminus(result.T_odom_body, T_world_odom.inverse() * truth);
    run.final_error_m = error.tail<3>().norm();
    run.final_error_rad = error.head<3>().norm();
    run.worst_error_m = std::max(run.worst_error_m, run.final_error_m);
    EXPECT_TRUE(result.T_odom_body.p.allFinite());
    run.results.push_back(result);
  }
  const Vec3 g = T_world_odom.R * odometry->gravity_odom();
  run.gravity_error_rad = std::acos(std::min(1.0, -g.normalized().z()));
  run.hash = odometry->state_hash();
  return run;
}

bool has_finding(const DriveLog& run, const std::string& id) {
  for (const Finding& f : run.findings) {
    if (f.id == id) return true;
  }
  return false;
}

TEST(RobustOdometry, drives_through_a_room_with_inertial_data_within_2_cm) {
  TestRoom room;
  const DriveLog run = drive(room, 5.0, true);
  EXPECT_LT(run.final_error_m, 0.02);
  EXPECT_LT(run.worst_error_m, 0.03);
  EXPECT_LT(run.final_error_rad, 0.005);
  EXPECT_LT(run.gravity_error_rad, 0.01);
  EXPECT_TRUE(has_finding(run, "odometry.start_at_rest"));
  EXPECT_EQ(run.results.back().state, TrackState::kGood);
}

TEST(RobustOdometry, drives_through_a_room_without_inertial_data_within_5_cm) {
  TestRoom room;
  room.rest_s = 0.3;
  const DriveLog run = drive(room, 3.5, false);
  EXPECT_LT(run.final_error_m, 0.05);
  EXPECT_LT(run.final_error_rad, 0.01);
}

TEST(RobustOdometry, finds_gravity_when_started_in_motion) {
  TestRoom room;
  room.rest_s = -3.0;  // has been driving for three seconds
  const DriveLog run = drive(room, 4.0, true);
  EXPECT_TRUE(has_finding(run, "odometry.start_in_motion"));
  EXPECT_LT(run.final_error_m, 0.05);
  EXPECT_LT(run.gravity_error_rad, 0.03);
}

// It turns at half a radian per second from the first point of the first scan on: a map that starts
// with that scan distorted would stay rotated by half of that against the first pose.
TEST(RobustOdometry, starting_in_a_turn_does_not_rotate_the_first_pose) {
  TestRoom room;
  room.rest_s = -3.0;
  room.radius_m = 2.0;
  const DriveLog run = drive(room, 4.0, true);
  EXPECT_LT(run.final_error_rad, 0.005);
  EXPECT_LT(run.final_error_m, 0.02);
}

// A yaw of the LiDAR that is off turns the whole path against the first heading, 0.8 m after 23 m,
// and no scan shows it. The wheels do.
TEST(RobustOdometry, reports_a_wrong_yaw_of_the_mounting) {
  for (const double yaw_off_deg : {2.0, 0.0}) {
    TestRoom room;
    room.walls = {{-5.0, -4.0, -1.0}, {40.0, 6.5, 2.6}};
    room.pillars.push_back({{14.0, -2.5, -1.0}, {14.5, -2.0, 2.6}});
    room.pillars.push_back({{22.0, 3.5, -1.0}, {22.6, 4.1, 2.6}});
    room.pillars.push_back({{30.0, -2.5, -1.0}, {30.5, -2.0, 2.6}});
    room.T_body_imu.R = geometry::rotation_from_rpy(0.0, 0.0, M_PI / 2);
    room.radius_m = 1e4;
    room.speed_mps = 1.5;
    const DriveLog run = drive(room, 17.0, true, yaw_off_deg);
    EXPECT_EQ(has_finding(run, "odometry.mounting"), yaw_off_deg > 0.0);
    EXPECT_EQ(run.final_error_m > 0.5, yaw_off_deg > 0.0);
  }
}

TEST(RobustOdometry, estimates_body_poses_with_a_rotated_and_offset_imu) {
  TestRoom room;
  room.T_body_imu = {
      geometry::rotation_from_rpy(0.0, 0.0, M_PI / 2) * geometry::rotation_from_rpy(M_PI, 0.0, 0.0),
      Vec3(-0.4, 0.3, 0.1)};
  const DriveLog run = drive(room, 3.5, true);
  EXPECT_LT(run.final_error_m, 0.02);
  EXPECT_LT(run.worst_error_m, 0.03);
  EXPECT_LT(run.gravity_error_rad, 0.01);
}

// It rolls for half a second and then stops. Standstill now does not imply standstill since the
// start: the first pose must not be taken as the present one.
TEST(RobustOdometry, a_stop_after_starting_in_motion_does_not_reset_the_pose) {
  TestRoom room;
  room.rest_s = -1.0;
  room.stop_s = 0.35;
  const DriveLog run = drive(room, 3.0, true);
  // The few scans before the stop leave the first pose a few centimetres off the map; if reset to
  // it, the vehicle would be off by the 0.25 m that it had driven.
  EXPECT_LT(run.final_error_m, 0.06);
  EXPECT_LT(run.worst_error_m, 0.08);  // 0.068 of it before the second scan shows any speed
}

TEST(RobustOdometry, keeps_the_pose_within_0_01_mm_at_standstill) {
  TestRoom room;
  room.rest_s = 100.0;
  const DriveLog run = drive(room, 4.0, true);
  EXPECT_LT(run.worst_error_m, 0.005);
  const std::size_t n = run.results.size();
  for (std::size_t k = n - 8; k < n; ++k) {
    EXPECT_LT((run.results[k].T_odom_body.p - run.results[n - 1].T_odom_body.p).norm(), 1e-5);
    EXPECT_EQ(run.results[k].keyframe, nullptr);
  }
}

TEST(RobustOdometry, keeps_the_pose_during_lidar_dropouts_at_standstill) {
  TestRoom room;
  room.rest_s = 100.0;
  const auto odometry = make_odometry(OdometrySettings{}, {room.T_body_lidar, {}}, true);
  SerialExecutor executor;
  FindingList findings;
  // Stamps as of today: a read beyond the queue by mistake gives an older one.
  const Duration since_1970 = Duration::from_s(1.7e9);
  int imu_index = 0;
  SE3 before;
  for (int k = 0; k < 80; ++k) {
    for (; 0.005 * imu_index <= 0.1 * (k + 1); ++imu_index) {
      sensor::ImuSample sample = room.imu(0.005 * imu_index);
      sample.t = sample.t + since_1970;
      odometry->add_imu(sample);
    }
    // Several times longer than the stored history of a standstill.
    if (k > 30 && k % 16 < 12) continue;
    sensor::LidarScan scan = *room.scan(0.1 * k);
    scan.t_start = scan.t_start + since_1970;
    scan.t_end = scan.t_end + since_1970;
    const ScanResult r = odometry->process(scan, executor, findings);
    if (k == 30) {
      EXPECT_TRUE(r.at_rest);
    } else if (k > 30) {
      EXPECT_LT((r.T_odom_body.p - before.p).norm(), 1e-3) << k;
    }
    before = r.T_odom_body;
  }
}

TEST(RobustOdometry, same_data_give_the_same_bytes) {
  TestRoom a;
  TestRoom b;
  a.rings = b.rings = 8;
  EXPECT_EQ(drive(a, 2.0, true).hash, drive(b, 2.0, true).hash);
}

TEST(RobustOdometry, an_empty_scan_does_not_reduce_the_covariance) {
  TestRoom room;
  room.rest_s = -1.0;
  const auto odometry = make_odometry(OdometrySettings{}, {room.T_body_lidar, {}}, false);
  SerialExecutor executor;
  FindingList findings;
  double sigma2_m2 = 0.0;
  for (int k = 0; k < 25; ++k) {
    const ScanResult r = odometry->process(*room.scan(0.1 * k), executor, findings);
    sigma2_m2 = r.covariance.bottomRightCorner<3, 3>().trace();
  }
  auto empty = std::make_shared<sensor::LidarScan>();
  empty->t_start = Time::from_s(2.5);
  empty->t_end = Time::from_s(2.599);
  const ScanResult r = odometry->process(*empty, executor, findings);
  EXPECT_EQ(r.state, TrackState::kPredicted);
  EXPECT_GT((r.covariance.bottomRightCorner<3, 3>().trace()), sigma2_m2);
}

TEST(RobustOdometry, reports_divergence_and_restarts_after_long_empty_scans) {
  TestRoom room;
  room.rings = 8;
  const auto odometry = make_odometry(OdometrySettings{}, {room.T_body_lidar, {}}, false);
  SerialExecutor executor;
  FindingList findings;
  for (int k = 0; k < 5; ++k) {
    static_cast<void>(odometry->process(*room.scan(0.1 * k), executor, findings));
  }
  EXPECT_TRUE(findings.empty());
  sensor::LidarScan empty;
  bool diverged = false;
  for (int k = 5; k < 30; ++k) {
    empty.t_start = Time::from_s(0.1 * k);
    empty.t_end = Time::from_s(0.1 * k + 0.099);
    const ScanResult r = odometry->process(empty, executor, findings);
    EXPECT_TRUE(r.T_odom_body.p.allFinite());
    EXPECT_TRUE(r.covariance.allFinite());
    diverged = diverged || r.state == TrackState::kDiverged;
  }
  EXPECT_TRUE(diverged);
  ASSERT_FALSE(findings.empty());
  EXPECT_EQ(findings.front().id, "odometry.diverged");
  ScanResult r;
  for (int k = 30; k < 35; ++k) r = odometry->process(*room.scan(0.1 * k), executor, findings);
  EXPECT_EQ(r.state, TrackState::kGood);
}

/// The next scan, with a gyro that clips at its range.
ScanResult turn_beyond(Driven& driven, double range_radps) {
  const double until_s = TestRoom::kScan_s * (driven.scans + 1);
  for (; 0.005 * driven.imu_samples <= until_s + 1e-9; ++driven.imu_samples) {
    sensor::ImuSample sample = driven.room.imu(0.005 * driven.imu_samples);
    sample.gyro_radps = sample.gyro_radps.cwiseMax(-range_radps).cwiseMin(range_radps);
    driven.odometry->add_imu(sample);
  }
  return driven.scan();
}

// Half of the rotation is missing in the prediction: points 10 m away are outside the cells of
// their planes. Searched in those cells alone, a pose rotated as the gyro measured and drove off,
// 11 m in campaign seed 660.
TEST(RobustOdometry, follows_a_turn_beyond_the_gyro_range) {
  TestRoom room;
  room.walls = {{-12.0, -9.0, -1.0}, {14.0, 11.0, 2.6}};
  room.speed_mps = 3.0;  // 1.5 rad/s
  Driven driven(room, 12, true);
  double worst_m = 0.0;
  double worst_rad = 0.0;
  while (driven.scans < 50) {
    const SE3 estimate = turn_beyond(driven, 0.75).T_odom_body;
    const SE3 truth = driven.room.pose(driven.t_end.s());
    worst_m = std::max(worst_m, (estimate.p - truth.p).norm());
    worst_rad = std::max(worst_rad, geometry::so3_log(truth.R.transpose() * estimate.R).norm());
  }
  EXPECT_LT(worst_m, 0.1);
  EXPECT_LT(worst_rad, 0.03);
}

}  // namespace
}  // namespace rali::odometry
