#include "rali/odometry/robust/map_tilt.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace rali::odometry {
namespace {

using geometry::Mat3;
using geometry::Vec3;

constexpr double kG_mps2 = 9.81;
constexpr double kDegree = std::numbers::pi / 180.0;

/// One second at 1 m/s; gravity in odom is that of a map turned by `tilt`, as a rotation vector.
TiltStep second(const Vec3& tilt_rad, double yaw_rad, const Vec3& bias_mps2) {
  TiltStep step;
  step.span_s = 1.0;
  step.travelled_m = 1.0;
  step.R_odom_body = geometry::so3_exp(Vec3(0.0, 0.0, yaw_rad));
  const Vec3 g = geometry::so3_exp(tilt_rad) * Vec3(0.0, 0.0, -kG_mps2);
  step.gravity_dv_mps = g - step.R_odom_body * bias_mps2;
  step.speed_sigma_mps = 0.01;
  step.accel_noise_mps2_rthz = 0.02;
  return step;
}

TEST(MapTilt, is_zero_for_a_straight_map_at_any_slope_and_bias) {
  MapTilt tilt(0.15);
  for (int t_s = 0; t_s < 100; ++t_s) {
    tilt.add(second(Vec3(0.05, -0.1, 0.0), 0.05 * t_s, Vec3(0.1, -0.05, 0.0)));
  }
  EXPECT_EQ(tilt.tilt_rad(), Eigen::Vector2d::Zero());
}

TEST(MapTilt, estimates_a_growing_tilt_to_within_0_2_degrees) {
  for (const double deg_per_m : {0.01, -0.01}) {
    MapTilt tilt(0.15);
    for (int t_s = 0; t_s <= 80; ++t_s) {
      tilt.add(second(Vec3(0.0, deg_per_m * kDegree * t_s, 0.0), 0.0, Vec3(0.05, 0.0, 0.0)));
    }
    EXPECT_NEAR(tilt.tilt_rad().y() / kDegree, 80.0 * deg_per_m, 0.2);
    EXPECT_NEAR(tilt.tilt_rad().x() / kDegree, 0.0, 1e-3);
  }
}

TEST(MapTilt, ignores_the_velocity_step_across_an_interruption) {
  MapTilt whole(0.15), broken(0.15);
  for (int t_s = 0; t_s < 60; ++t_s) {
    const TiltStep step = second(Vec3(0.0, 0.02 * kDegree * t_s, 0.0), 0.0, Vec3::Zero());
    whole.add(step);
    broken.add(step);
  }
  ASSERT_GT(whole.tilt_rad().y(), 0.5 * kDegree);
  TiltStep jolt = second(Vec3::Zero(), 0.0, Vec3::Zero());
  jolt.gravity_dv_mps.x() += 5.0;  // its velocity is not that of the last step
  broken.interrupt();
  broken.add(jolt);
  EXPECT_NEAR(broken.tilt_rad().y(), whole.tilt_rad().y(), 0.1 * kDegree);
}

}  // namespace
}  // namespace rali::odometry
