#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "rali/odometry/robust/driven_for_test.hpp"

namespace rali::odometry {
namespace {

using geometry::Vec3;

bool contradicts(const Driven& driven) {
  return std::any_of(driven.findings.begin(), driven.findings.end(), [](const Finding& f) {
    return f.text.find("usual are") != std::string::npos;
  });
}

// A slipping vehicle, or a failing sensor, once led the pose 600 m off in a minute at a sigma of 9
// m.
TEST(SpeedBound, resets_an_implausible_speed_and_widens_the_position_sigma) {
  Driven driven(tunnel(), 25, true);
  ASSERT_TRUE(driven.filter->degenerate_axis());
  const double before_m = std::sqrt(driven.filter->position_covariance()(0, 0));
  double max_mps = 0.0;
  ScanResult result;
  for (int k = 0; k < 20 && !contradicts(driven); ++k) {
    result = drive_pushed(driven, 5, 1.0);
    max_mps = std::max(max_mps, std::abs(result.v_odom_mps.x()));
  }
  ASSERT_TRUE(contradicts(driven));
  EXPECT_LT(max_mps, 20.0);
  EXPECT_LT(driven.findings.back().t, driven.findings.back().t_end);
  // The vehicle has driven at 1 m/s; the force of 1 m/s2 had led the pose off by 15 m and more.
  const double off_m = result.T_odom_body.p.x() - driven.room.pose(driven.t_end.s()).p.x();
  const double sigma_m = std::sqrt(driven.filter->position_covariance()(0, 0));
  EXPECT_LT(std::abs(off_m), 3.0 * sigma_m);
  EXPECT_GT(sigma_m, before_m + 2.0);
  EXPECT_LT(std::abs(driven.now().v_odom_mps.x()), 6.0);
}

// A car enters a tunnel faster than the settings expect: the LiDAR has observed that speed.
TEST(SpeedBound, accepts_a_speed_that_the_lidar_has_observed) {
  OdometrySettings settings;
  settings.robust.constraints.speed_usual_mps = 0.1;
  TestRoom room = small_room();
  room.pillars.clear();
  Driven driven(room, 100, true, settings);
  ASSERT_FALSE(driven.filter->degenerate_axis());
  ASSERT_GT(driven.now().v_odom_mps.norm(), 0.8);
  driven.room.walls.lo.x() = -4000.0;
  driven.room.walls.hi.x() = 4000.0;
  drive_pushed(driven, 60, 0.0);
  ASSERT_TRUE(driven.filter->degenerate_axis());
  EXPECT_FALSE(contradicts(driven));
}

// Applied repeatedly the prior would pull the speed to zero.
TEST(SpeedBound, bounds_the_speed_sigma_without_driving_it_to_zero) {
  constexpr double kUsual_mps = 1.0;
  OdometrySettings settings;
  settings.robust.constraints.speed_usual_mps = kUsual_mps;
  Driven driven(tunnel(), 25, true, settings);
  driven.room.accel_noise_mps2 = 2.0;  // shaking, otherwise it would count as standstill
  ASSERT_TRUE(driven.filter->degenerate_axis());
  double largest_mps = 0.0;
  double last_mps = 0.0;
  for (int k = 0; k < 600; ++k) {
    driven.scan();
    last_mps = std::sqrt(driven.filter->covariance(unit_rows(*driven.filter))(6, 6));
    largest_mps = std::max(largest_mps, last_mps);
  }
  EXPECT_GT(largest_mps, 0.9 * kUsual_mps);
  EXPECT_GT(last_mps, 0.6 * kUsual_mps);
}

TEST(SpeedBound, reports_no_contradiction_at_usual_speed) {
  Driven driven(tunnel(), 25, true);
  drive_pushed(driven, 60, 0.0);
  EXPECT_FALSE(contradicts(driven));
}

}  // namespace
}  // namespace rali::odometry
