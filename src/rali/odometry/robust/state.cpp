#include "rali/odometry/robust/state.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "rali/geometry/regression.hpp"
#include "rali/imu/kinematics.hpp"

namespace rali::odometry {

using geometry::Mat3;
using geometry::skew;
using geometry::so3_exp;
using geometry::so3_right_jacobian;
using geometry::Vec3;

Eigen::Matrix<double, 3, 2> gravity_basis(const Vec3& g) {
  // The axis least aligned with g gives a well conditioned and continuous frame near vertical.
  const Vec3 n = g.normalized();
  const Vec3 helper = std::abs(n.x()) < 0.9 ? Vec3::UnitX() : Vec3::UnitY();
  Eigen::Matrix<double, 3, 2> B;
  B.col(0) = n.cross(helper).normalized();
  B.col(1) = n.cross(Vec3(B.col(0)));
  return B;
}

void add_error(FilterState& state, const StateVec& delta) {
  state.T_odom_body.R = state.T_odom_body.R * so3_exp(delta.segment<3>(kTheta));
  state.T_odom_body.p += delta.segment<3>(kPos);
  state.v += delta.segment<3>(kVel);
  state.gyro_bias_radps += delta.segment<3>(kGyroBias);
  state.accel_bias_mps2 += delta.segment<3>(kAccelBias);
  const auto turn = [](Vec3& g, const Eigen::Vector2d& by) {
    g = so3_exp(gravity_basis(g) * by) * g;
  };
  turn(state.g_odom_mps2, delta.segment<2>(kGravity));
  turn(state.g_first_odom_mps2, delta.segment<2>(kFirstGravity));
  state.tilt_radpm += delta[kTiltRate];
}

void propagate_covariance(FilterState& state, const StateCov& F) {
  state.P = F * state.P * F.transpose();
  if (state.augmented.size() > 0) state.P_augmented = (F * state.P_augmented).eval();
}

void decorrelate(FilterState& state, int first, int n) {
  state.P.middleRows(first, n).setZero();
  state.P.middleCols(first, n).setZero();
  state.P_augmented.middleRows(first, n).setZero();
}

namespace {

/// From one estimate of gravity to another, in the tangent of the first.
Eigen::Vector2d turn_between(const Vec3& from, const Vec3& to) {
  return gravity_basis(from).transpose() * geometry::so3_log(geometry::rotation_between(from, to));
}

}  // namespace

double force_sigma_mps2(const FilterState& state) {
  const Mat3& R = state.T_odom_body.R;
  const Vec3& g = state.g_odom_mps2;
  // Of bias - R^T g, in odom.
  Eigen::Matrix<double, 3, kStateDim> H = Eigen::Matrix<double, 3, kStateDim>::Zero();
  H.block<3, 3>(0, kTheta) = -R * skew(Vec3(R.transpose() * g));
  H.block<3, 3>(0, kAccelBias) = R;
  H.block<3, 2>(0, kGravity) = skew(g) * gravity_basis(g);
  const Mat3 P = H * state.P * H.transpose();
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(P, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues()[2]));
}

void carry_augmented_states(const FilterState& with, FilterState& state) {
  const Eigen::MatrixXd gain = geometry::regression(with.P_augmented.transpose(), with.P);
  StateVec shift;
  shift << geometry::so3_log(with.T_odom_body.R.transpose() * state.T_odom_body.R),
      state.T_odom_body.p - with.T_odom_body.p, state.v - with.v,
      state.gyro_bias_radps - with.gyro_bias_radps, state.accel_bias_mps2 - with.accel_bias_mps2,
      turn_between(with.g_odom_mps2, state.g_odom_mps2),
      turn_between(with.g_first_odom_mps2, state.g_first_odom_mps2),
      state.tilt_radpm - with.tilt_radpm;
  state.augmented.mean = with.augmented.mean + gain * shift;
  state.augmented.covariance =
      with.augmented.covariance + gain * (state.P - with.P) * gain.transpose();
  state.P_augmented = state.P * gain.transpose();
}

void propagate_inertial(FilterState& state, const Vec3& gyro_radps, const Vec3& accel_mps2,
                        double dt_s, const ProcessNoise& noise) {
  const Vec3 w = gyro_radps - state.gyro_bias_radps;
  const Vec3 a = accel_mps2 - state.accel_bias_mps2;
  const Mat3 R = state.T_odom_body.R * so3_exp(0.5 * dt_s * w);
  const Mat3 Rdt = R * dt_s;
  const Mat3 Ra_dt = Rdt * skew(a);
  const Eigen::Matrix<double, 3, 2> g_dt =
      -dt_s * (skew(state.g_odom_mps2) * gravity_basis(state.g_odom_mps2));

  StateCov F = StateCov::Identity();
  F.block<3, 3>(kTheta, kTheta) = so3_exp(-dt_s * w);
  F.block<3, 3>(kTheta, kGyroBias) = -dt_s * so3_right_jacobian(dt_s * w);
  F.block<3, 3>(kVel, kTheta) = -Ra_dt;
  F.block<3, 3>(kVel, kAccelBias) = -Rdt;
  F.block<3, 2>(kVel, kGravity) = g_dt;
  F.block<3, 3>(kPos, kVel) = dt_s * Mat3::Identity();
  F.block<3, 3>(kPos, kTheta) = -0.5 * dt_s * Ra_dt;
  F.block<3, 3>(kPos, kAccelBias) = -0.5 * dt_s * Rdt;
  F.block<3, 2>(kPos, kGravity) = 0.5 * dt_s * g_dt;
  propagate_covariance(state, F);

  // White noise enters through the same Jacobians; R R^T = I makes the blocks multiples of I.
  const double qg = noise.gyro_radps_rthz * noise.gyro_radps_rthz * dt_s;
  const double qa = noise.accel_mps2_rthz * noise.accel_mps2_rthz * dt_s;
  state.P.diagonal().segment<3>(kTheta).array() += qg;
  state.P.diagonal().segment<3>(kVel).array() += qa;
  state.P.diagonal().segment<3>(kPos).array() += 0.25 * dt_s * dt_s * qa;
  for (int i = 0; i < 3; ++i) {
    state.P(kPos + i, kVel + i) += 0.5 * dt_s * qa;
    state.P(kVel + i, kPos + i) += 0.5 * dt_s * qa;
  }
  state.P.diagonal().segment<3>(kGyroBias).array() += noise.gyro_walk * noise.gyro_walk * dt_s;
  state.P.diagonal().segment<3>(kAccelBias).array() += noise.accel_walk * noise.accel_walk * dt_s;

  imu::KinematicState k{state.T_odom_body, state.v};
  imu::integrate(k, w, a, state.g_odom_mps2, dt_s);
  state.T_odom_body = k.T_odom_body;
  state.v = k.v_odom_mps;
}

void propagate_constant_velocity(FilterState& state, double dt_s, const ProcessNoise& noise) {
  const Vec3 w = state.gyro_bias_radps;
  const Vec3 step = w * dt_s;
  // Left Jacobian: integral of Exp(w s) ds / dt.
  const Mat3 V = so3_right_jacobian(-step);
  const Mat3 R = state.T_odom_body.R;
  const Vec3 travel = V * state.v * dt_s;  // in the body at the start

  StateCov F = StateCov::Identity();
  F.block<3, 3>(kTheta, kTheta) = so3_exp(-step);
  F.block<3, 3>(kTheta, kGyroBias) = dt_s * so3_right_jacobian(step);
  F.block<3, 3>(kPos, kTheta) = -R * skew(travel);
  F.block<3, 3>(kPos, kVel) = R * V * dt_s;
  F.block<3, 3>(kPos, kGyroBias) = -0.5 * dt_s * dt_s * R * skew(state.v);
  propagate_covariance(state, F);

  const double qv = noise.accel_walk * noise.accel_walk * dt_s;
  const double qw = noise.gyro_walk * noise.gyro_walk * dt_s;
  const double third = dt_s * dt_s / 3.0;
  state.P.diagonal().segment<3>(kVel).array() += qv;
  state.P.diagonal().segment<3>(kGyroBias).array() += qw;
  state.P.diagonal().segment<3>(kPos).array() += third * qv;
  state.P.diagonal().segment<3>(kTheta).array() += third * qw;

  state.T_odom_body.p += R * travel;
  state.T_odom_body.R = R * so3_exp(step);
}

}  // namespace rali::odometry
