#include "rali/odometry/robust/state.hpp"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::odometry {
namespace {

using geometry::Mat3;
using geometry::so3_exp;
using geometry::so3_log;
using geometry::Vec3;

Vec3 random_vector(Rng& rng, double scale) {
  return scale * Vec3(rng.normal(), rng.normal(), rng.normal());
}

FilterState random_state(Rng& rng) {
  FilterState s;
  s.T_odom_body = {so3_exp(random_vector(rng, 1.5)), random_vector(rng, 10.0)};
  s.v = random_vector(rng, 2.0);
  s.gyro_bias_radps = random_vector(rng, 0.02);
  s.accel_bias_mps2 = random_vector(rng, 0.1);
  s.g_odom_mps2 = 9.81 * random_vector(rng, 1.0).normalized();
  s.g_first_odom_mps2 = 9.81 * random_vector(rng, 1.0).normalized();
  s.tilt_radpm = 0.01 * rng.normal();
  return s;
}

/// delta with a (+) delta = b.
StateVec difference(const FilterState& b, const FilterState& a) {
  StateVec d;
  d.segment<3>(kTheta) = so3_log(a.T_odom_body.R.transpose() * b.T_odom_body.R);
  d.segment<3>(kPos) = b.T_odom_body.p - a.T_odom_body.p;
  d.segment<3>(kVel) = b.v - a.v;
  d.segment<3>(kGyroBias) = b.gyro_bias_radps - a.gyro_bias_radps;
  d.segment<3>(kAccelBias) = b.accel_bias_mps2 - a.accel_bias_mps2;
  const auto turn = [](const Vec3& from, const Vec3& to) {
    return Eigen::Vector2d(gravity_basis(from).transpose() *
                           so3_log(geometry::rotation_between(from, to)));
  };
  d.segment<2>(kGravity) = turn(a.g_odom_mps2, b.g_odom_mps2);
  d.segment<2>(kFirstGravity) = turn(a.g_first_odom_mps2, b.g_first_odom_mps2);
  d[kTiltRate] = b.tilt_radpm - a.tilt_radpm;
  return d;
}

template <class Propagate>
StateCov numerical_F(const FilterState& at, Propagate propagate) {
  constexpr double kStep = 1e-5;
  StateCov F;
  for (int k = 0; k < kStateDim; ++k) {
    FilterState plus = at;
    FilterState minus = at;
    add_error(plus, kStep * StateVec::Unit(k));
    add_error(minus, -kStep * StateVec::Unit(k));
    propagate(plus);
    propagate(minus);
    FilterState center = at;
    propagate(center);
    F.col(k) = (difference(plus, center) - difference(minus, center)) / (2.0 * kStep);
  }
  return F;
}

/// F from the covariance: one unit of variance in one error gives F e e^T F^T. The column F e is
/// read from it, up to its sign, at the row where `like` is largest.
template <class Propagate>
StateCov covariance_F(const FilterState& at, Propagate propagate, const StateCov& like) {
  StateCov F;
  for (int k = 0; k < kStateDim; ++k) {
    FilterState s = at;
    s.P = StateVec::Unit(k) * StateVec::Unit(k).transpose();
    propagate(s);
    Eigen::Index row = 0;
    static_cast<void>(like.col(k).cwiseAbs().maxCoeff(&row));
    F.col(k) = std::copysign(1.0, like(row, k)) * s.P.col(row) / std::sqrt(s.P(row, row));
  }
  return F;
}

template <class Propagate>
StateCov error_of_F(const FilterState& at, Propagate propagate) {
  const StateCov F = numerical_F(at, propagate);
  return covariance_F(at, propagate, F) - F;
}

TEST(FilterState, add_error_and_difference_are_inverse) {
  Rng rng(1, "state");
  for (int k = 0; k < 20; ++k) {
    const FilterState a = random_state(rng);
    StateVec d;
    for (int i = 0; i < kStateDim; ++i) d[i] = 0.3 * rng.normal();
    FilterState b = a;
    add_error(b, d);
    EXPECT_LT((difference(b, a) - d).norm(), 1e-12);
    EXPECT_NEAR(b.g_odom_mps2.norm(), 9.81, 1e-12);
    EXPECT_EQ(b.P, a.P);
  }
}

TEST(FilterState, gravity_basis_is_orthonormal_in_every_direction) {
  Rng rng(2, "basis");
  for (int k = 0; k < 50; ++k) {
    const Vec3 g = k < 3 ? Vec3(-9.81 * Vec3::Unit(k)) : random_vector(rng, 5.0);
    const Eigen::Matrix<double, 3, 2> B = gravity_basis(g);
    EXPECT_LT((B.transpose() * B - Eigen::Matrix2d::Identity()).norm(), 1e-14);
    EXPECT_LT((B.transpose() * g).norm(), 1e-13 * g.norm());
  }
}

// F is of first order in the step within each block: the neglected part is of second order, small
// at 200 Hz. Rows of position have one more dt.
TEST(PropagateInertial, covariance_follows_numerical_jacobians_at_any_attitude) {
  Rng rng(3, "inertial");
  for (int k = 0; k < 10; ++k) {
    const FilterState s = random_state(rng);
    const Vec3 gyro = random_vector(rng, 1.0);
    const Vec3 accel = random_vector(rng, 8.0);
    const auto error_at = [&](double dt_s) {
      const auto step = [&](FilterState& x) { propagate_inertial(x, gyro, accel, dt_s, {}); };
      return error_of_F(s, step);
    };
    constexpr double kDt_s = 0.005;
    const StateCov error = error_at(kDt_s);
    const double second_order = kDt_s * kDt_s * (1.0 + gyro.norm()) * (1.0 + accel.norm());
    EXPECT_LT(error.middleRows<3>(kTheta).norm(), 1e-8);
    EXPECT_LT(error.middleRows<3>(kVel).norm(), second_order);
    EXPECT_LT(error.middleRows<3>(kPos).norm(), kDt_s * second_order);
    EXPECT_LT(error.bottomRows<kStateDim - 9>().norm(), 1e-8);
    // A wrong term of first order would only halve with the step.
    EXPECT_LT(error_at(0.5 * kDt_s).norm(), 0.27 * error.norm());
  }
}

TEST(PropagateInertial, agrees_with_closed_form_motion_after_subtracting_biases) {
  FilterState s;
  s.gyro_bias_radps = Vec3(0.0, 0.0, 0.01);
  s.accel_bias_mps2 = Vec3(0.05, 0.0, 0.0);
  for (int k = 0; k < 200; ++k) {
    propagate_inertial(s, Vec3(0.0, 0.0, 0.51), Vec3(1.05, 0.0, 9.81), 0.005, {});
  }
  EXPECT_LT((so3_log(s.T_odom_body.R) - Vec3(0.0, 0.0, 0.5)).norm(), 1e-9);
  EXPECT_LT((s.v - Vec3(0.958851, 0.244835, 0.0)).norm(), 2e-6);
  EXPECT_LT((s.T_odom_body.p - Vec3(0.489670, 0.082298, 0.0)).norm(), 4e-6);
}

// T1: white noise of 1e-3 rad/s/rtHz and 1e-2 m/s2/rtHz over one second.
TEST(PropagateInertial, noise_growth_matches_hand_computed_values) {
  FilterState s;
  s.g_odom_mps2 = Vec3(0.0, 0.0, -9.81);
  for (int k = 0; k < 200; ++k) {
    propagate_inertial(s, Vec3(0.0, 0.0, 0.5), Vec3(1.0, 0.0, 9.81), 0.005, {1e-3, 1e-2, 0.0, 0.0});
  }
  const StateVec sd = s.P.diagonal().cwiseSqrt();
  const double expected[] = {1e-3, 1e-3, 1e-3, 0.0062, 0.0062, 0.0058, 0.0115, 0.0115, 0.0100};
  for (int k = 0; k < 9; ++k) EXPECT_NEAR(sd[k], expected[k], 0.01 * expected[k]) << k;
  EXPECT_EQ(sd.tail<kStateDim - 9>().norm(), 0.0);
}

TEST(PropagateInertial, bias_sigma_grows_with_the_square_root_of_time) {
  FilterState s;
  for (int k = 0; k < 100; ++k)
    propagate_inertial(s, Vec3::Zero(), -s.g_odom_mps2, 0.04, {0, 0, 1e-3, 2e-3});
  EXPECT_NEAR(std::sqrt(s.P(kGyroBias, kGyroBias)), 2e-3, 1e-9);
  EXPECT_NEAR(std::sqrt(s.P(kAccelBias, kAccelBias)), 4e-3, 1e-9);
}

FilterState random_velocity_state(Rng& rng) {
  FilterState s = random_state(rng);
  s.gyro_bias_radps = random_vector(rng, 1.0);  // here: the body's rate
  return s;
}

TEST(PropagateConstantVelocity, covariance_follows_numerical_jacobians_at_large_rotation) {
  Rng rng(4, "cv");
  for (int k = 0; k < 10; ++k) {
    FilterState s = random_velocity_state(rng);
    s.gyro_bias_radps = (k < 5 ? 2.0 : 25.0) * s.gyro_bias_radps.normalized();
    constexpr double kDt_s = 0.1;  // up to 2.5 rad in one step
    const auto step = [&](FilterState& x) { propagate_constant_velocity(x, kDt_s, {}); };
    const StateCov error = error_of_F(s, step);
    EXPECT_LT(error.leftCols<9>().norm(), 1e-7) << k;
    EXPECT_LT(error.rightCols<5>().norm(), 1e-7) << k;
    EXPECT_LT(error.middleRows<3>(kTheta).norm(), 1e-7) << k;
    // Position by rate is of second order in dt, its neglected part of third.
    const double angle = kDt_s * s.gyro_bias_radps.norm();
    const geometry::Mat3 by_rate = error.block<3, 3>(kPos, kGyroBias);
    EXPECT_LT(by_rate.norm(), kDt_s * kDt_s * s.v.norm() * std::min(1.0, angle)) << k;
  }
}

TEST(PropagateConstantVelocity, drives_a_circle_exactly) {
  FilterState s;
  s.v = Vec3(2.0, 0.0, 0.0);
  s.gyro_bias_radps = Vec3(0.0, 0.0, 1.0);
  propagate_constant_velocity(s, M_PI / 2, {});  // a quarter of a circle of radius 2 m, one step
  EXPECT_LT((s.T_odom_body.p - Vec3(2.0, 2.0, 0.0)).norm(), 1e-14);
  EXPECT_LT((s.T_odom_body.R * Vec3::UnitX() - Vec3::UnitY()).norm(), 1e-15);
}

TEST(PropagateConstantVelocity, white_acceleration_grows_velocity_and_position_variance) {
  FilterState s;
  ProcessNoise noise;
  noise.accel_walk = 1.0;
  noise.gyro_walk = 0.5;
  for (int k = 0; k < 1000; ++k) propagate_constant_velocity(s, 1e-3, noise);
  EXPECT_NEAR(s.P(kVel, kVel), 1.0, 1e-9);
  EXPECT_NEAR(s.P(kPos, kPos), 1.0 / 3.0, 1e-2);  // integral of white acceleration, twice
  EXPECT_NEAR(s.P(kTheta, kTheta), 0.25 / 3.0, 1e-2);
}

// An accelerometer at rest measures the sum: 0.01 rad of tilt that a bias compensates are nothing.
TEST(ForceSigma, is_of_accelerometer_bias_and_gravity_together) {
  FilterState s;
  s.T_odom_body.R = geometry::so3_exp(Vec3(0.1, -0.2, 2.0));
  const double tilt_rad = 0.01;
  // Gravity turned about y of odom changes the force along x of odom by 9.81 m/s2 per rad.
  const Vec3 dg_mps2 = Vec3(0.0, tilt_rad, 0.0).cross(s.g_odom_mps2);
  StateVec v = StateVec::Zero();
  v.segment<2>(kGravity) = gravity_basis(s.g_odom_mps2).transpose() * Vec3(0.0, tilt_rad, 0.0);
  s.P = v * v.transpose();
  EXPECT_NEAR(force_sigma_mps2(s), 9.81 * tilt_rad, 1e-9);
  v.segment<3>(kAccelBias) = s.T_odom_body.R.transpose() * dg_mps2;
  s.P = v * v.transpose();
  EXPECT_NEAR(force_sigma_mps2(s), 0.0, 1e-9);
}

TEST(ForceSigma, an_error_of_the_attitude_counts_like_one_of_gravity) {
  FilterState s;
  s.T_odom_body.R = geometry::so3_exp(Vec3(0.1, -0.2, 2.0));
  const Vec3 turn_odom_rad(0.0, 0.01, 0.0);
  StateVec v = StateVec::Zero();
  v.segment<3>(kTheta) = s.T_odom_body.R.transpose() * turn_odom_rad;
  v.segment<2>(kGravity) = gravity_basis(s.g_odom_mps2).transpose() * turn_odom_rad;
  s.P = v * v.transpose();
  EXPECT_NEAR(force_sigma_mps2(s), 0.0, 1e-9) << "both turned by the same";
}

}  // namespace
}  // namespace rali::odometry
