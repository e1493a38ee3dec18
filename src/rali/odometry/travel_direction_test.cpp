#include "rali/odometry/travel_direction.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/geometry/so3.hpp"

namespace rali::odometry {
namespace {

using geometry::SE3;
using geometry::Vec3;

constexpr double kDegree = std::numbers::pi / 180.0;

/// Drives 40 m at 1 m/s with bends, in a direction turned by `left_deg` from x. The body's origin
/// is `lever_m` ahead of the axle. Poses have noise.
/// @param R_body_vehicle the body may be that of an inertial sensor
TravelDirection driven(double left_deg, double lever_m, double sway_m = 0.0,
                       const geometry::Mat3& R_body_vehicle = geometry::Mat3::Identity()) {
  Rng rng(3, "travel");
  TravelDirection direction;
  Vec3 axle = Vec3::Zero();
  double yaw = 0.4;
  for (int k = 0; k < 400; ++k) {
    const double rate = 0.5 * std::sin(0.02 * k);
    yaw += 0.1 * rate;
    const double heading = yaw + left_deg * kDegree;
    axle += 0.1 * Vec3(std::cos(heading), std::sin(heading), 0.0);
    SE3 T;
    T.R = geometry::rotation_from_rpy(0.0, 0.0, yaw + 0.001 * rng.normal());
    const Vec3 across(-std::sin(heading), std::cos(heading), 0.0);
    T.p = axle + lever_m * Vec3(std::cos(heading), std::sin(heading), 0.0) +
          sway_m * std::sin(0.3 * k) * across + 0.005 * Vec3(rng.normal(), rng.normal(), 0.0);
    T.R = T.R * R_body_vehicle.transpose();
    direction.add(T, R_body_vehicle.col(0), R_body_vehicle.col(2));
  }
  return direction;
}

TEST(TravelDirection, is_the_angle_by_which_the_mounting_is_off) {
  for (const double left_deg : {0.4, -2.0}) {
    const auto angle = driven(left_deg, 0.0).angle();
    ASSERT_TRUE(angle.has_value());
    EXPECT_NEAR(angle->left_rad / kDegree, left_deg, 0.1);
    EXPECT_LT(angle->sigma_rad / kDegree, 0.15);
  }
}

TEST(TravelDirection, is_that_of_the_vehicle_for_a_sensor_mounted_in_any_way) {
  const auto angle = driven(0.4, 0.0, 0.0, geometry::rotation_from_rpy(3.1, 0.2, 1.6)).angle();
  ASSERT_TRUE(angle.has_value());
  EXPECT_NEAR(angle->left_rad / kDegree, 0.4, 0.1);
}

TEST(TravelDirection, a_body_ahead_of_the_axle_swings_in_bends_and_is_not_turned) {
  const auto angle = driven(0.0, 0.8).angle();
  ASSERT_TRUE(angle.has_value());
  EXPECT_NEAR(angle->left_rad / kDegree, 0.0, 0.1);
}

TEST(TravelDirection, a_carrier_that_sways_leaves_it_uncertain) {
  const auto angle = driven(0.3, 0.0, 0.15).angle();
  ASSERT_TRUE(angle.has_value());
  EXPECT_GT(angle->sigma_rad / kDegree, 0.5);
}

TEST(TravelDirection, is_unknown_before_ten_metres_and_for_a_body_that_is_not_ahead_along_x) {
  EXPECT_FALSE(driven(90.0, 0.0).angle().has_value());
  TravelDirection direction;
  for (int k = 0; k < 90; ++k)
    direction.add({geometry::Mat3::Identity(), {0.1 * k, 0.0, 0.0}}, Vec3::UnitX(), Vec3::UnitZ());
  EXPECT_FALSE(direction.angle().has_value());
}

TEST(TravelDirection, a_jump_of_the_pose_is_no_step) {
  TravelDirection direction;
  for (int k = 0; k < 400; ++k) {
    if (k == 200) direction.interrupt();
    const double off_m = k < 200 ? 0.0 : 5.0;
    direction.add({geometry::Mat3::Identity(), {0.1 * k, off_m, 0.0}}, Vec3::UnitX(),
                  Vec3::UnitZ());
  }
  ASSERT_TRUE(direction.angle().has_value());
  EXPECT_NEAR(direction.angle()->left_rad, 0.0, 1e-9);
}

}  // namespace
}  // namespace rali::odometry
