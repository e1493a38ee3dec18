#include "rali/imu/preintegration.hpp"

#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::imu {
namespace {

using geometry::Mat3;
using geometry::so3_exp;
using geometry::so3_log;
using geometry::Vec3;

const Vec3 kGravity(0.0, 0.0, -9.81);

struct Turning {
  Vec3 w = Vec3(0.0, 0.0, 0.5);
  Vec3 a = Vec3(1.0, 0.0, 9.81);
  int samples = 200;
  double dt_s = 0.005;
};

// Test T1 of the design: one second of constant turning.
Preintegration turning(const InertialBias& bias = {}, const Turning& motion = {}) {
  Preintegration pre(bias, {1e-3, 1e-2});
  for (int k = 0; k < motion.samples; ++k) EXPECT_TRUE(pre.add(motion.w, motion.a, motion.dt_s));
  return pre;
}

Vec3 random_vector(Rng& rng, double scale) {
  return scale * Vec3(rng.normal(), rng.normal(), rng.normal());
}

Preintegration random_motion(Rng& rng, const InertialBias& bias) {
  Preintegration pre(bias, {1e-3, 1e-2});
  for (int k = 0; k < 60; ++k) {
    EXPECT_TRUE(pre.add(random_vector(rng, 0.8), random_vector(rng, 3.0) - kGravity,
                        rng.uniform(0.002, 0.01)));
  }
  return pre;
}

InertialState random_state(Rng& rng) {
  return {so3_exp(random_vector(rng, 1.0)), random_vector(rng, 5.0), random_vector(rng, 2.0)};
}

TEST(Preintegration, agrees_with_the_closed_form_of_a_constant_turn) {
  const Preintegration pre = turning();
  EXPECT_NEAR(pre.duration_s(), 1.0, 1e-12);
  EXPECT_LT((so3_log(pre.delta_rotation({})) - Vec3(0.0, 0.0, 0.5)).norm(), 1e-9);
  // Rotation at the start of each interval would give (0.959157, 0.243636): 1.2 mm/s off.
  EXPECT_LT((pre.delta_velocity_mps({}) - Vec3(0.958851, 0.244835, 9.81)).norm(), 2e-6);
  EXPECT_LT((pre.delta_position_m({}) - Vec3(0.489670, 0.082298, 4.905)).norm(), 4e-6);
}

TEST(Preintegration, has_the_bias_jacobians_of_a_constant_turn) {
  const Preintegration pre = turning();
  EXPECT_NEAR(pre.d_rotation_d_gyro()(2, 2), -1.0, 1e-12);
  Mat3 dva;
  dva << 0.958851, -0.244835, 0.0, 0.244835, 0.958851, 0.0, 0.0, 0.0, 1.0;
  Mat3 dpa;
  dpa << 0.489670, -0.082298, 0.0, 0.082298, 0.489670, 0.0, 0.0, 0.0, 0.5;
  EXPECT_LT((pre.d_velocity_d_accel() + dva).norm(), 1e-5);
  EXPECT_LT((pre.d_position_d_accel() + dpa).norm(), 1e-5);
}

TEST(Preintegration, has_the_standard_deviations_of_a_constant_turn) {
  const Vec9 sd = turning().covariance().diagonal().cwiseSqrt();
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(sd(k), 1.0e-3, 5e-6);
  EXPECT_NEAR(sd(3), 0.0115, 1e-4);
  EXPECT_NEAR(sd(4), 0.0115, 1e-4);
  EXPECT_NEAR(sd(5), 0.0100, 1e-4);
  EXPECT_NEAR(sd(6), 0.0062, 1e-4);
  EXPECT_NEAR(sd(7), 0.0062, 1e-4);
  EXPECT_NEAR(sd(8), 0.0058, 1e-4);
}

TEST(Preintegration, corrects_a_bias_to_first_order) {
  const InertialBias bias{Vec3(0.0, 0.0, 0.01), Vec3(0.05, 0.0, 0.0)};
  const Preintegration exact = turning(bias);
  const Preintegration first_order = turning();
  EXPECT_LT((first_order.delta_velocity_mps(bias) - exact.delta_velocity_mps(bias)).norm(), 2.5e-4);
  EXPECT_LT((first_order.delta_position_m(bias) - exact.delta_position_m(bias)).norm(), 1e-4);
  EXPECT_LT(
      so3_log(first_order.delta_rotation(bias).transpose() * exact.delta_rotation(bias)).norm(),
      1e-9);
}

// The accumulated Jacobians against integrating all samples again: an error in any of the five
// recursions shows.
TEST(Preintegration, bias_jacobians_are_derivatives_of_the_integration_itself) {
  constexpr double kStep = 1e-5;
  for (int axis = 0; axis < 6; ++axis) {
    Rng rng_plus(7);
    Rng rng_minus(7);
    Rng rng(7);
    InertialBias plus;
    (axis < 3 ? plus.gyro_radps : plus.accel_mps2)(axis % 3) = kStep;
    const InertialBias minus{-plus.gyro_radps, -plus.accel_mps2};
    const Preintegration a = random_motion(rng_plus, plus);
    const Preintegration b = random_motion(rng_minus, minus);
    const Preintegration mid = random_motion(rng, {});
    const Vec3 dv = (a.delta_velocity_mps(plus) - b.delta_velocity_mps(minus)) / (2 * kStep);
    const Vec3 dp = (a.delta_position_m(plus) - b.delta_position_m(minus)) / (2 * kStep);
    const Mat3& Jv = axis < 3 ? mid.d_velocity_d_gyro() : mid.d_velocity_d_accel();
    const Mat3& Jp = axis < 3 ? mid.d_position_d_gyro() : mid.d_position_d_accel();
    EXPECT_LT((dv - Jv.col(axis % 3)).norm(), 1e-8);
    EXPECT_LT((dp - Jp.col(axis % 3)).norm(), 1e-8);
    if (axis >= 3) continue;
    const Mat3 R0T = mid.delta_rotation({}).transpose();
    const Vec3 dR =
        (so3_log(R0T * a.delta_rotation(plus)) - so3_log(R0T * b.delta_rotation(minus))) /
        (2 * kStep);
    EXPECT_LT((dR - mid.d_rotation_d_gyro().col(axis)).norm(), 1e-8);
  }
}

struct Arguments {
  InertialState i, j;
  InertialBias bias;
};

// Columns: pose i (6), velocity i (3), pose j (6), velocity j (3), bias (6).
Arguments moved(const Arguments& at, int column, double step) {
  Arguments out = at;
  Vec9 d = Vec9::Zero();
  if (column < 18) {
    InertialState& s = column < 9 ? out.i : out.j;
    d(column % 9) = step;
    s.R_odom_imu = s.R_odom_imu * so3_exp(d.head<3>());
    s.p_odom_m += d.segment<3>(3);
    s.v_odom_mps += d.tail<3>();
    return out;
  }
  d(column - 18) = step;
  out.bias.gyro_radps += d.head<3>();
  out.bias.accel_mps2 += d.segment<3>(3);
  return out;
}

Eigen::Matrix<double, 9, 24> stacked(const InertialResidual& r) {
  Eigen::Matrix<double, 9, 24> J;
  J << r.d_pose_i, r.d_velocity_i, r.d_pose_j, r.d_velocity_j, r.d_bias;
  return J;
}

// Five points: with three, truncation or rounding would hide an error of 1e-8.
Vec9 numeric_column(const Preintegration& pre, const Arguments& at, int column) {
  constexpr double kStep = 1e-3;
  const auto r = [&](double step) {
    const Arguments m = moved(at, column, step);
    return pre.residual(m.i, m.j, kGravity, m.bias).r;
  };
  return (8.0 * (r(kStep) - r(-kStep)) - (r(2 * kStep) - r(-2 * kStep))) / (12.0 * kStep);
}

TEST(Preintegration, all_residual_jacobians_agree_with_central_differences) {
  Rng rng(3);
  double worst = 0.0;
  for (int trial = 0; trial < 5; ++trial) {
    const Preintegration pre = random_motion(rng, {Vec3(0.01, 0, 0), Vec3(0, 0.1, 0)});
    Arguments at{random_state(rng), {}, {Vec3(0.013, -0.002, 0.001), Vec3(0.03, 0.12, -0.02)}};
    at.j = pre.predict(at.i, kGravity, at.bias);
    at.j.R_odom_imu = at.j.R_odom_imu * so3_exp(random_vector(rng, 0.2));
    at.j.p_odom_m += random_vector(rng, 0.3);
    at.j.v_odom_mps += random_vector(rng, 0.3);
    const auto J = stacked(pre.residual(at.i, at.j, kGravity, at.bias));
    for (int c = 0; c < 24; ++c) {
      worst = std::max(worst, (J.col(c) - numeric_column(pre, at, c)).cwiseAbs().maxCoeff());
    }
  }
  RecordProperty("worst_jacobian_error", std::to_string(worst));
  EXPECT_LT(worst, 1e-8);
}

TEST(Preintegration, residual_is_zero_at_its_own_prediction) {
  Rng rng(4);
  for (int trial = 0; trial < 20; ++trial) {
    const Preintegration pre = random_motion(rng, {});
    const InertialState i = random_state(rng);
    const InertialState j = pre.predict(i, kGravity, {});
    EXPECT_LT(pre.residual(i, j, kGravity, {}).r.norm(), 1e-9);
  }
}

// Rotating odom about the vertical or shifting it must not change the residual.
TEST(Preintegration, residual_is_invariant_to_yaw_and_origin_of_odom) {
  Rng rng(5);
  const Preintegration pre = random_motion(rng, {});
  const InertialState i = random_state(rng);
  const InertialState j = random_state(rng);
  const Mat3 Rz = so3_exp(Vec3(0, 0, 1.234));
  const Vec3 shift(3.0, -2.0, 7.0);
  const auto move = [&](const InertialState& s) {
    return InertialState{Rz * s.R_odom_imu, Rz * s.p_odom_m + shift, Rz * s.v_odom_mps};
  };
  const Vec9 difference =
      pre.residual(i, j, kGravity, {}).r - pre.residual(move(i), move(j), kGravity, {}).r;
  EXPECT_LT(difference.norm(), 1e-10);
}

TEST(Preintegration, two_half_intervals_predict_the_same_as_the_whole) {
  Rng rng(6);
  Preintegration whole({}, {});
  Preintegration halves[2] = {Preintegration({}, {}), Preintegration({}, {})};
  for (int k = 0; k < 80; ++k) {
    const Vec3 w = random_vector(rng, 1.0);
    const Vec3 a = random_vector(rng, 4.0);
    ASSERT_TRUE(whole.add(w, a, 0.005));
    ASSERT_TRUE(halves[k / 40].add(w, a, 0.005));
  }
  const InertialState start = random_state(rng);
  const InertialState middle = halves[0].predict(start, kGravity, {});
  const InertialState end = halves[1].predict(middle, kGravity, {});
  const InertialState direct = whole.predict(start, kGravity, {});
  EXPECT_LT((end.p_odom_m - direct.p_odom_m).norm(), 1e-10);
  EXPECT_LT((end.v_odom_mps - direct.v_odom_mps).norm(), 1e-10);
  EXPECT_LT((end.R_odom_imu - direct.R_odom_imu).norm(), 1e-10);
}

TEST(Preintegration, covariance_is_symmetric_positive_and_grows) {
  Rng rng(8);
  Preintegration pre({}, {1e-3, 1e-2});
  double last_trace = 0.0;
  for (int k = 0; k < 100; ++k) {
    ASSERT_TRUE(pre.add(random_vector(rng, 1.0), random_vector(rng, 4.0), 0.005));
    const Mat9& P = pre.covariance();
    EXPECT_EQ(P, P.transpose());
    EXPECT_GT(P.trace(), last_trace);
    last_trace = P.trace();
  }
  EXPECT_GT(pre.covariance().ldlt().vectorD().minCoeff(), 0.0);
}

// Samples drawn with the stated noise scatter as the covariance predicts.
TEST(Preintegration, covariance_agrees_with_monte_carlo) {
  Rng rng(9);
  const Preintegration clean = turning();
  const Turning motion{.samples = 100, .dt_s = 0.01};
  const double scale = 1.0 / std::sqrt(motion.dt_s);
  Vec9 squares = Vec9::Zero();
  constexpr int kRuns = 600;
  for (int run = 0; run < kRuns; ++run) {
    Preintegration noisy({}, {1e-3, 1e-2});
    for (int k = 0; k < motion.samples; ++k) {
      ASSERT_TRUE(noisy.add(motion.w + random_vector(rng, 1e-3 * scale),
                            motion.a + random_vector(rng, 1e-2 * scale), motion.dt_s));
    }
    Vec9 e;
    e << so3_log(clean.delta_rotation({}).transpose() * noisy.delta_rotation({})),
        noisy.delta_velocity_mps({}) - clean.delta_velocity_mps({}),
        noisy.delta_position_m({}) - clean.delta_position_m({});
    squares += e.cwiseAbs2();
  }
  const Vec9 sd = (squares / kRuns).cwiseSqrt();
  const Vec9 claimed = clean.covariance().diagonal().cwiseSqrt();
  for (int k = 0; k < 9; ++k) EXPECT_NEAR(sd(k) / claimed(k), 1.0, 0.12) << "component " << k;
}

TEST(Preintegration, refuses_invalid_samples_and_remains_unchanged) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Preintegration pre = turning();
  const Vec3 before = pre.delta_velocity_mps({});
  EXPECT_FALSE(pre.add(Vec3(nan, 0, 0), Vec3::Zero(), 0.01));
  EXPECT_FALSE(pre.add(Vec3::Zero(), Vec3(0, std::numeric_limits<double>::infinity(), 0), 0.01));
  EXPECT_FALSE(pre.add(Vec3::Zero(), Vec3::Zero(), 0.0));
  EXPECT_FALSE(pre.add(Vec3::Zero(), Vec3::Zero(), -0.01));
  EXPECT_FALSE(pre.add(Vec3::Zero(), Vec3::Zero(), nan));
  EXPECT_FALSE(pre.add(Vec3::Zero(), Vec3::Zero(), 1.01));
  EXPECT_EQ(pre.delta_velocity_mps({}), before);
  EXPECT_EQ(pre.size(), 200U);
}

std::vector<sensor::ImuSample> samples_each_10_ms(int n) {
  std::vector<sensor::ImuSample> out;
  for (int k = 0; k < n; ++k) {
    out.push_back({Time::from_ns(10'000'000LL * k), Vec3::Zero(), Vec3(k, 0, 0)});
  }
  return out;
}

TEST(Preintegration, stream_integrates_partial_samples_at_both_ends) {
  const auto samples = samples_each_10_ms(4);  // accelerations 0, 1, 2, 3 m/s^2
  Preintegration pre({}, {});
  const double covered =
      pre.add_stream(samples, Time::from_ns(15'000'000), Time::from_ns(33'000'000));
  // 5 ms of 1, 10 ms of 2, 3 ms of 3.
  EXPECT_NEAR(covered, 0.018, 1e-12);
  EXPECT_NEAR(pre.delta_velocity_mps({}).x(), 0.005 + 0.020 + 0.009, 1e-12);
}

TEST(Preintegration, stream_holds_the_first_and_last_sample_over_the_edges) {
  const auto samples = samples_each_10_ms(2);  // 0 and 1 m/s^2
  Preintegration pre({}, {});
  EXPECT_NEAR(pre.add_stream(samples, Time::from_ns(-10'000'000), Time::from_ns(30'000'000)), 0.04,
              1e-12);
  EXPECT_NEAR(pre.delta_velocity_mps({}).x(), 0.020, 1e-12);
  Preintegration nothing({}, {});
  EXPECT_EQ(nothing.add_stream({}, Time{}, Time::from_ns(1)), 0.0);
  EXPECT_EQ(nothing.size(), 0U);
}

}  // namespace
}  // namespace rali::imu
