#include "rali/odometry/robust/acceleration.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "rali/odometry/robust/driven_for_test.hpp"

namespace rali::odometry {
namespace {

using geometry::Mat3;
using geometry::SE3;
using geometry::Vec3;

/// Drives along a circle with scans `period_s` apart; the speed grows by `accel_mps2`.
double seen_mps2(double accel_mps2, double period_s, double turn_radps = 0.0) {
  AccelerationWatch watch;
  double seen = 0.0;
  for (int k = 0; k * period_s < 6.0; ++k) {
    const double speed = 1.0 + accel_mps2 * k * period_s;
    const SE3 step{geometry::so3_exp(Vec3(0.0, 0.0, turn_radps * period_s)),
                   Vec3(speed * period_s, 0.0, 0.0)};
    watch.add(Time::from_s(100.0 + k * period_s), step);
    seen = watch.mean_mps2().value_or(0.0);
  }
  return seen;
}

TEST(AccelerationWatch, gives_the_mean_over_a_second_at_any_rate_of_scans) {
  for (const double period_s : {0.05, 0.1, 0.5}) {
    EXPECT_NEAR(seen_mps2(3.0, period_s), 3.0, 0.05) << period_s;
    EXPECT_NEAR(seen_mps2(0.0, period_s), 0.0, 1e-6) << period_s;
  }
  // 1 m/s and 0.5 rad/s: centripetal.
  EXPECT_NEAR(seen_mps2(0.0, 0.1, 0.5), 0.5, 0.03);
}

TEST(AccelerationWatch, gives_no_mean_across_a_gap_or_after_a_reset) {
  AccelerationWatch watch;
  const SE3 step{Mat3::Identity(), Vec3(0.1, 0.0, 0.0)};
  for (int k = 0; k < 30; ++k) watch.add(Time::from_s(0.1 * k), step);
  ASSERT_TRUE(watch.mean_mps2());
  watch.add(Time::from_s(6.0), {Mat3::Identity(), Vec3(50.0, 0.0, 0.0)});
  EXPECT_FALSE(watch.mean_mps2());
  watch.reset();
  EXPECT_FALSE(watch.mean_mps2());
}

TEST(UnexplainedShift, is_the_part_beyond_3_sigma_along_the_shift) {
  const Mat3 P = Vec3(4.0, 0.0001, 0.0001).asDiagonal();
  EXPECT_EQ(unexplained_shift({5.0, 0.0, 0.0}, P), Vec3::Zero()) << "a blind axis seen again";
  EXPECT_NEAR(unexplained_shift({0.0, 5.0, 0.0}, P).y(), 4.97, 1e-9);
  EXPECT_EQ(unexplained_shift(Vec3::Zero(), P), Vec3::Zero());
}

bool is_lost(const Driven& driven, const char* why) {
  return std::any_of(driven.findings.begin(), driven.findings.end(), [why](const Finding& f) {
    return f.id == "odometry.diverged" && f.text.find(why) != std::string::npos;
  });
}

TEST(AccelerationBound, reports_divergence_when_acceleration_exceeds_the_vehicle_limit) {
  OdometrySettings settings;
  settings.robust.constraints.accel_max_mps2 = 0.2;  // the vehicle speeds up by 1 m/s in a second
  settings.robust.constraints.standstill = false;    // all the while its pose follows
  for (const bool has_imu : {true, false}) {
    const Driven slow(small_room(), 35, has_imu, settings);
    EXPECT_TRUE(is_lost(slow, "accelerates")) << has_imu;
    const Driven usual(small_room(), 35, has_imu);
    EXPECT_FALSE(is_lost(usual, "")) << has_imu;
  }
}

}  // namespace
}  // namespace rali::odometry
