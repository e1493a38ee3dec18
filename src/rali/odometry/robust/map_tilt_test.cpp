#include "rali/odometry/robust/map_tilt.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace rali::odometry {
namespace {

using geometry::Vec3;

constexpr double kG_mps2 = 9.81;
constexpr double kDegree = std::numbers::pi / 180.0;
const TiltRate kRate{0.01 * kDegree, 30.0};
const TiltRate kConstant{0.01 * kDegree, 1e12};

/// Drives along x at 1 m/s; gravity is known to a milliradian.
FilterState driving() {
  FilterState state;
  state.v = Vec3(1.0, 0.0, 0.0);
  state.P.diagonal().setConstant(1e-12);
  state.P.diagonal().segment<2>(kGravity).setConstant(1e-6);
  begin_tilt(state, kRate);
  return state;
}

TEST(MapTilt, starts_with_one_gravity_and_no_tilt) {
  const FilterState state = driving();
  EXPECT_EQ(state.g_first_odom_mps2, state.g_odom_mps2);
  EXPECT_DOUBLE_EQ(state.P(kFirstGravity, kFirstGravity), state.P(kGravity, kGravity));
  EXPECT_DOUBLE_EQ(state.P(kFirstGravity, kGravity), state.P(kGravity, kGravity));
  EXPECT_DOUBLE_EQ(std::sqrt(state.P(kTiltRate, kTiltRate)), kRate.sigma_radpm);
  EXPECT_EQ(map_tilt_rad(state), Eigen::Vector2d::Zero());
}

// By hand: 10 m at 0.1 degrees per metre lower the nose by 1 degree, about y to the left.
TEST(MapTilt, turns_vehicle_speed_and_gravity_in_common_and_back_again) {
  FilterState state = driving();
  state.tilt_radpm = 0.1 * kDegree;
  tilt_with_map(state, Vec3(10.0, 0.0, 0.0), kConstant);
  const double s = std::sin(kDegree), c = std::cos(kDegree);
  EXPECT_LT((state.g_odom_mps2 - kG_mps2 * Vec3(-s, 0.0, -c)).norm(), 1e-6);
  EXPECT_LT((state.v - Vec3(c, 0.0, -s)).norm(), 1e-6);
  EXPECT_LT((state.T_odom_body.R.col(0) - Vec3(c, 0.0, -s)).norm(), 1e-6);
  EXPECT_EQ(state.g_first_odom_mps2, Vec3(0.0, 0.0, -kG_mps2));

  tilt_with_map(state, Vec3(-10.0 * c, 0.0, 10.0 * s), kConstant);
  EXPECT_LT((state.g_odom_mps2 - Vec3(0.0, 0.0, -kG_mps2)).norm(), 1e-6);
  EXPECT_LT((state.T_odom_body.R - geometry::Mat3::Identity()).norm(), 1e-6);
}

// By hand: half the rate from here on; the half degree of the first 10 m stays.
TEST(MapTilt, keeps_what_has_tilted_when_the_rate_is_found_to_be_smaller) {
  FilterState state = driving();
  state.tilt_radpm = 0.05 * kDegree;
  tilt_with_map(state, Vec3(10.0, 0.0, 0.0), kConstant);
  const FilterState before = state;
  scale_tilt(state, 0.5);
  EXPECT_DOUBLE_EQ(state.tilt_radpm, 0.5 * before.tilt_radpm);
  EXPECT_EQ(state.g_odom_mps2, before.g_odom_mps2);
  EXPECT_DOUBLE_EQ(state.P(kTiltRate, kTiltRate), 0.25 * before.P(kTiltRate, kTiltRate));
  EXPECT_DOUBLE_EQ(state.P(kGravity, kTiltRate), 0.5 * before.P(kGravity, kTiltRate));
  EXPECT_EQ(state.P(kGravity, kGravity), before.P(kGravity, kGravity));
}

TEST(MapTilt, does_not_grow_on_the_spot_or_straight_up) {
  FilterState state = driving();
  state.tilt_radpm = 0.1 * kDegree;
  const geometry::Mat3 R = state.T_odom_body.R;
  const double sigma = state.P(kGravity, kGravity);
  tilt_with_map(state, Vec3::Zero(), kRate);
  tilt_with_map(state, Vec3(0.0, 0.0, 3.0), kRate);
  EXPECT_EQ(state.T_odom_body.R, R);
  EXPECT_DOUBLE_EQ(state.P(kGravity, kGravity), sigma);
}

// A rate of 0.01 degrees per metre (1 sigma) that lasts for 30 m: over 1 m it is the rate itself.
TEST(MapTilt, is_as_uncertain_as_the_rate_after_a_metre_and_less_than_linear_after_many) {
  FilterState state = driving();
  const auto tilt_sigma_rad = [&state] {
    double variance = state.P(kGravity + 1, kGravity + 1) +
                      state.P(kFirstGravity + 1, kFirstGravity + 1) -
                      2.0 * state.P(kGravity + 1, kFirstGravity + 1);
    variance += state.P(kGravity, kGravity) + state.P(kFirstGravity, kFirstGravity) -
                2.0 * state.P(kGravity, kFirstGravity);
    return std::sqrt(variance);
  };
  for (int k = 0; k < 10; ++k) tilt_with_map(state, Vec3(0.1, 0.0, 0.0), kRate);
  EXPECT_NEAR(tilt_sigma_rad(), kRate.sigma_radpm, 0.02 * kRate.sigma_radpm);
  for (int k = 0; k < 1190; ++k) tilt_with_map(state, Vec3(0.1, 0.0, 0.0), kRate);
  // Ornstein-Uhlenbeck: sigma L sqrt(2 (d/L - 1 + exp(-d/L))), with d = 120 m.
  const double d = 4.0;
  const double expected = 30.0 * std::sqrt(2.0 * (d - 1.0 + std::exp(-d))) * kRate.sigma_radpm;
  EXPECT_NEAR(tilt_sigma_rad(), expected, 0.02 * expected);
  EXPECT_NEAR(std::sqrt(state.P(kTiltRate, kTiltRate)), kRate.sigma_radpm, 1e-9);
}

TEST(MapTilt, has_the_covariance_of_numerical_jacobians) {
  FilterState state = driving();
  state.T_odom_body.R = geometry::so3_exp(Vec3(0.2, -0.1, 1.0));
  state.v = Vec3(0.7, -0.4, 0.1);
  state.P.setZero();
  state.P(kTiltRate, kTiltRate) = 1.0;  // then the cross terms are the column of the Jacobian
  const Vec3 moved_m(0.6, -0.3, 0.1);
  constexpr double kStep = 1e-6;
  FilterState plus = state, minus = state;
  plus.tilt_radpm = kStep;
  minus.tilt_radpm = -kStep;
  for (FilterState* s : {&state, &plus, &minus}) tilt_with_map(*s, moved_m, kConstant);
  const Vec3 theta =
      geometry::so3_log(minus.T_odom_body.R.transpose() * plus.T_odom_body.R) / (2.0 * kStep);
  const Vec3 dv = (plus.v - minus.v) / (2.0 * kStep);
  const Vec3 dg = (plus.g_odom_mps2 - minus.g_odom_mps2) / (2.0 * kStep);
  const Vec3 by_gravity =
      gravity_basis(state.g_odom_mps2) * state.P.block<2, 1>(kGravity, kTiltRate);
  EXPECT_LT((state.P.block<3, 1>(kTheta, kTiltRate) - theta).norm(), 1e-8);
  EXPECT_LT((state.P.block<3, 1>(kVel, kTiltRate) - dv).norm(), 1e-8);
  EXPECT_LT((by_gravity.cross(state.g_odom_mps2) - dg).norm(), 1e-7);
}

// An accelerometer of known bias measures gravity at a place 30 m on, 0.3 degrees off the first.
TEST(MapTilt, is_the_turn_of_gravity_unless_noise_explains_it) {
  FilterState state = driving();
  for (int k = 0; k < 300; ++k) tilt_with_map(state, Vec3(0.1, 0.0, 0.0), kRate);
  state.g_odom_mps2 = geometry::so3_exp(Vec3(0.0, 0.3 * kDegree, 0.0)) * state.g_odom_mps2;
  EXPECT_EQ(map_tilt_rad(state), Eigen::Vector2d::Zero())
      << "no surprise: its sigma is 0.26 degrees";
  state.P.block<2, 2>(kGravity, kGravity) = 1e-8 * Eigen::Matrix2d::Identity();
  state.P.block<2, 2>(kFirstGravity, kFirstGravity) = 1e-8 * Eigen::Matrix2d::Identity();
  state.P.block<2, 2>(kGravity, kFirstGravity).setZero();
  state.P.block<2, 2>(kFirstGravity, kGravity).setZero();
  EXPECT_NEAR(map_tilt_rad(state).y(), 0.3 * kDegree, 1e-3 * kDegree);
  EXPECT_NEAR(map_tilt_rad(state).x(), 0.0, 1e-6);
}

}  // namespace
}  // namespace rali::odometry
