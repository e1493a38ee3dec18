// A LiDAR that something covers while the vehicle drives: dust, spray, a curtain.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "rali/odometry/make_odometry.hpp"
#include "rali/odometry/room_for_test.hpp"

namespace rali::odometry {
namespace {

using geometry::SE3;

/// Every ray of at least `share` of the circle ends at most this far away.
void cover(sensor::LidarScan& scan, double range_m, double share) {
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const double x_m = scan.x_m[i], y_m = scan.y_m[i], z_m = scan.z_m[i];
    const double turn = 0.5 + std::atan2(y_m, x_m) / (2.0 * std::numbers::pi);
    if (turn > share) continue;
    const double r_m = std::hypot(x_m, y_m, z_m);
    const auto s = static_cast<float>(std::min(1.0, range_m / r_m));
    scan.x_m[i] *= s;
    scan.y_m[i] *= s;
    scan.z_m[i] *= s;
  }
}

struct Drive {
  double begin_s = 6.0, end_s = 6.0;  ///< covered
  double range_m = 0.6, share = 1.0;
};

struct Driven {
  double error_max_m = 0.0, error_end_m = 0.0;
  int unused = 0;  ///< scans that were predicted
  FindingList findings;

  [[nodiscard]] const Finding* covered() const {
    const auto f = std::find_if(findings.begin(), findings.end(),
                                [](const Finding& g) { return g.id == "odometry.covered"; });
    return f != findings.end() ? &*f : nullptr;
  }
};

Driven driven(const Drive& drive) {
  constexpr double kDuration_s = 12.0;
  TestRoom room;
  const auto odometry = make_odometry(OdometrySettings{}, {room.T_body_lidar, {}}, true);
  SerialExecutor executor;
  Driven out;
  SE3 T_world_odom;
  int imu_index = 0;
  for (int k = 0; 0.1 * (k + 1) <= kDuration_s; ++k) {
    const double t_s = 0.1 * k;
    for (; 0.005 * imu_index <= t_s + 0.1; ++imu_index) {
      odometry->add_imu(room.imu(0.005 * imu_index));
    }
    const auto scan = room.scan(t_s);
    if (t_s > drive.begin_s - 0.05 && t_s < drive.end_s - 0.05) {
      cover(*scan, drive.range_m, drive.share);
    }
    const ScanResult result = odometry->process(*scan, executor, out.findings);
    const SE3 truth = room.pose(scan->t_end.s());
    if (k == 0) T_world_odom = truth * result.T_odom_body.inverse();
    out.error_end_m = (result.T_odom_body.p - (T_world_odom.inverse() * truth).p).norm();
    out.error_max_m = std::max(out.error_max_m, out.error_end_m);
    out.unused += k > 20 && result.state == TrackState::kPredicted ? 1 : 0;
  }
  odometry->finish(out.findings);
  return out;
}

// Half a second inside a box of 0.6 m put vehicles 14 to 55 m off: its points entered the map, and
// the box moved along.
TEST(RobustCover, inertial_data_bridge_scans_of_something_that_covers_the_lidar) {
  for (const double range_m : {0.6, 1.0}) {
    const Driven run = driven({6.0, 7.0, range_m});
    EXPECT_LT(run.error_max_m, 0.05) << range_m;
    EXPECT_LT(run.error_end_m, 0.03) << range_m;
    EXPECT_EQ(run.unused, 10) << range_m;
    ASSERT_NE(run.covered(), nullptr) << range_m;
    EXPECT_NEAR(run.covered()->t.s(), 6.0, 0.01);
    EXPECT_NEAR(run.covered()->t_end.s(), 7.0, 0.01);
  }
}

TEST(RobustCover, a_cover_that_stays_to_the_end_is_reported) {
  const Driven run = driven({11.0, 13.0});
  ASSERT_NE(run.covered(), nullptr);
  EXPECT_LT(run.error_end_m, 0.05);
}

// A person or a pillar beside the vehicle hides a part: the rest of the scan still fits.
TEST(RobustCover, a_scan_that_is_hidden_in_part_is_used) {
  const Driven run = driven({6.0, 7.0, 0.6, 0.3});
  EXPECT_EQ(run.covered(), nullptr);
  EXPECT_EQ(run.unused, 0);
  EXPECT_LT(run.error_max_m, 0.03);
}

TEST(RobustCover, nothing_is_reported_of_a_drive_without_cover) {
  EXPECT_EQ(driven({}).covered(), nullptr);
}

}  // namespace
}  // namespace rali::odometry
