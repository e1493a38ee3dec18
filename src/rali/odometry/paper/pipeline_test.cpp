#include "rali/odometry/paper/pipeline.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include <gtest/gtest.h>

#include "rali/odometry/paper/paper_odometry.hpp"
#include "rali/odometry/paper/testing/synthetic_room.hpp"

namespace rali::odometry {
namespace {

using geometry::Vec3;
using paper::testing::Drive;
using paper::testing::Imu;
using paper::testing::Lidar;
using paper::testing::Room;
using paper::testing::scan;

/// Reports x as unconstrained by the LiDAR, whatever the normals, and corrects nothing.
struct DegenerateAlongX final : KeyframeCorrector {
  std::optional<Vec3> degenerate_direction(std::span<const Vec3> /*normals_body*/,
                                           const Vec3& /*up_body*/) const override {
    return Vec3::UnitX();
  }

  std::optional<KeyframeMove> at_keyframe(const ScanResult& /*scan*/,
                                          const KeyframeInertia& /*inertia*/) override {
    ++keyframes;
    return std::nullopt;
  }

  int keyframes = 0;
};

struct Trip {
  int standing = 0;
  int driving = 0;
  ScanResult last;
  FindingList findings;
};

Trip run(Odometry& odometry, const Room& room, const Lidar& lidar, const Drive& drive,
         double end_s) {
  const Imu imu;
  Rng rng(1);
  SerialExecutor executor;
  Trip trip;
  double imu_s = 0.0;
  for (double t_s = 0.1; t_s < end_s; t_s += 0.1) {
    for (; imu_s <= t_s + 0.0051; imu_s += 0.005) odometry.add_imu(imu.sample(drive, imu_s, rng));
    const ScanResult r =
        odometry.process(scan(room, drive, lidar, t_s, rng), executor, trip.findings);
    if (r.state == TrackState::kWaiting) continue;
    if (t_s > drive.rest_s) {
      trip.driving += r.at_rest ? 0 : 1;
    } else {
      trip.standing += r.at_rest ? 1 : 0;
    }
    trip.last = r;
  }
  return trip;
}

std::unique_ptr<Odometry> odometry_for(const Lidar& lidar) {
  sensor::Calibration calibration;
  calibration.T_body_lidar = lidar.T_body_lidar;
  calibration.T_body_imu = Imu().T_body_imu;
  return make_paper_odometry(OdometrySettings{}, calibration, true);
}

Lidar lidar_of_32_rings() {
  Lidar lidar;
  lidar.rings = 32;
  lidar.columns = 450;
  return lidar;
}

TEST(PaperPipeline, reports_standstill_while_standing_and_motion_while_driving) {
  // Otherwise the vehicle is never used as an anchor, and every range to it is refused.
  const Lidar lidar = lidar_of_32_rings();
  const auto odometry = odometry_for(lidar);
  Drive drive;
  drive.rest_s = 4.0;
  const Trip trip = run(*odometry, Room{}, lidar, drive, 7.0);
  EXPECT_GT(trip.standing, 15);
  EXPECT_GT(trip.driving, 20);
  EXPECT_TRUE(trip.last.inertial);
}

TEST(PaperPipeline, reports_lost_when_sigma_along_a_degenerate_direction_exceeds_1_m) {
  const Lidar lidar = lidar_of_32_rings();
  const auto odometry = odometry_for(lidar);
  DegenerateAlongX corrector;
  odometry->correct_keyframes_by(&corrector);
  Drive drive;
  drive.yaw_rad = 0.0;
  Room tunnel;
  tunnel.low.x() = -500.0;
  tunnel.high.x() = 500.0;
  const Trip trip = run(*odometry, tunnel, lidar, drive, 15.0);
  const double along_m = std::sqrt(trip.last.covariance(3, 3));
  const double across_m = std::sqrt(trip.last.covariance(4, 4));
  std::printf("[   DATA   ] after 14 s: sigma %.2f m along, %.3f m across\n", along_m, across_m);
  EXPECT_GT(along_m, 0.5);
  EXPECT_LT(across_m, 0.1);
  EXPECT_GT(corrector.keyframes, 5);
  const bool lost = std::any_of(trip.findings.begin(), trip.findings.end(),
                                [](const Finding& f) { return f.id == "odometry.lost"; });
  EXPECT_EQ(lost, along_m > 1.0);
}

}  // namespace
}  // namespace rali::odometry
