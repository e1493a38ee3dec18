// A vehicle at standstill in a lift.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "rali/odometry/make_odometry.hpp"
#include "rali/odometry/room_for_test.hpp"

namespace rali::odometry {
namespace {

/// The room is the cabin: it accelerates up from 4 s on for 2 s, and comes to rest by 8 s.
double force_mps2(double t_s, double accel_mps2) {
  if (t_s > 4.0 && t_s < 6.0) return accel_mps2 * std::sin(std::numbers::pi * (t_s - 4.0) / 2.0);
  if (t_s > 6.0 && t_s < 8.0) return -accel_mps2 * std::sin(std::numbers::pi * (t_s - 6.0) / 2.0);
  return 0.0;
}

struct Ride {
  double end_height_m = 0.0, end_error_m = 0.0;  ///< after the vehicle has driven on
  double sigma_m = 0.0;
  FindingList findings;

  [[nodiscard]] bool says(const char* id) const {
    return std::any_of(findings.begin(), findings.end(),
                       [id](const Finding& f) { return f.id == id; });
  }
};

/// @param ends the cabin stops; otherwise the first force goes on
/// @param end_s of the recording; after the standstill by default
/// @param doors_s from then on the LiDAR sees the cabin displaced
Ride ride(double accel_mps2, bool ends, double rest_s, double end_s = 0.0, double doors_s = 1e9) {
  TestRoom room;
  room.rest_s = rest_s;
  const auto odometry = make_odometry(OdometrySettings{}, {room.T_body_lidar, {}}, true);
  SerialExecutor executor;
  Ride out;
  int imu_index = 0;
  for (int k = 0; 0.1 * (k + 1) <= (end_s > 0.0 ? end_s : rest_s + 4.0); ++k) {
    const double t_s = 0.1 * k;
    for (; 0.005 * imu_index <= t_s + 0.1; ++imu_index) {
      sensor::ImuSample sample = room.imu(0.005 * imu_index);
      const double t = 0.005 * imu_index;
      const double force =
          ends ? force_mps2(t, accel_mps2) : (t > 4.0 && t < rest_s ? accel_mps2 : 0.0);
      const geometry::Mat3 R = room.pose(t).R;
      sample.accel_mps2 += R.transpose() * geometry::Vec3(0.0, 0.0, force);
      odometry->add_imu(sample);
    }
    const auto scan = room.scan(t_s);
    if (t_s > doors_s) {
      for (float& x_m : scan->x_m) x_m -= 0.06F;
    }
    const ScanResult result = odometry->process(*scan, executor, out.findings);
    const geometry::Vec3 error = result.T_odom_body.p - room.pose(scan->t_end.s()).p;
    out.end_height_m = error.z();
    out.end_error_m = error.head<2>().norm();
    out.sigma_m = std::sqrt(result.covariance(5, 5));
  }
  odometry->finish(out.findings);
  return out;
}

// The LiDAR sees a cabin that stands still: the height was taken to be unchanged, to 0.02 m.
TEST(RobustLift, the_pose_moves_with_the_cabin) {
  for (const double accel_mps2 : {1.0, -0.6, 0.3}) {
    // Twice the same speed profile: a half sine over 2 s gains 4/pi, at the mean for 4 s.
    const double height_m = accel_mps2 * 8.0 / std::numbers::pi;
    const Ride run = ride(accel_mps2, true, 10.0);
    EXPECT_NEAR(run.end_height_m, height_m, 0.1) << accel_mps2;
    EXPECT_LT(std::abs(run.end_height_m - height_m), 3.0 * run.sigma_m) << accel_mps2;
    EXPECT_LT(run.end_error_m, 0.06) << accel_mps2;
    EXPECT_TRUE(run.says("odometry.lift")) << accel_mps2;
  }
}

// To the LiDAR, doors that close are a motion of centimetres: it ends the standstill.
TEST(RobustLift, a_ride_begins_although_closing_doors_have_ended_the_standstill) {
  const Ride run = ride(1.0, true, 10.0, 9.8, 3.3);
  // Were the force integrated only once the vehicle stands again, 0.03 m of the ride would be lost.
  EXPECT_NEAR(run.end_height_m, 8.0 / std::numbers::pi, 0.015);
  EXPECT_TRUE(run.says("odometry.lift"));
}

TEST(RobustLift, an_accelerometer_that_fails_does_not_lift_a_vehicle_at_standstill) {
  const Ride run = ride(0.3, false, 40.0);
  EXPECT_LT(std::abs(run.end_height_m), 0.2);
  EXPECT_FALSE(run.says("odometry.lift"));
  EXPECT_TRUE(run.says("odometry.contradiction"));
}

TEST(RobustLift, a_recording_that_ends_in_the_ride_says_so) {
  const Ride still = ride(1.0, true, 10.0, 7.0);
  EXPECT_NEAR(still.end_height_m, 2.2, 0.4);
  EXPECT_TRUE(still.says("odometry.lift"));
}

TEST(RobustLift, nothing_is_said_at_standstill) {
  const Ride run = ride(0.0, true, 10.0);
  EXPECT_FALSE(run.says("odometry.lift"));
  EXPECT_FALSE(run.says("odometry.contradiction"));
  EXPECT_LT(std::abs(run.end_height_m), 0.05);
}

}  // namespace
}  // namespace rali::odometry
