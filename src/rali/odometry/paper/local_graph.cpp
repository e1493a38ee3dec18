#include "rali/odometry/paper/local_graph.hpp"

#include <Eigen/LU>

#include "rali/geometry/so3.hpp"

namespace rali::odometry::paper {

using geometry::Mat6;
using geometry::Vec3;
using geometry::Vec6;

namespace {

// Order of the state; rotation, velocity, position as in the preintegrated residual.
constexpr int kR = 0;
constexpr int kV = 3;
constexpr int kP = 6;
constexpr int kBg = 9;
constexpr int kBa = 12;

constexpr double kRestTiltRad = 5e-3;  // an accelerometer's bias of 0.05 m/s^2
constexpr double kMovingTiltRad = 0.05;
constexpr double kYawRad = 1e-4;
constexpr double kPositionM = 1e-4;
constexpr double kRestMps = 0.01;
constexpr double kMovingMps = 2.0;
constexpr double kStandingMps = 0.03;  // a start is detected late
constexpr double kRestGyroBias = 1e-3;
constexpr double kMovingGyroBias = 0.01;
constexpr double kAccelBias = 0.05;
constexpr double kMeanForce = 0.01;  // [m/s^2] of the mean over a second at standstill
constexpr double kGravityMps2 = 9.81;
constexpr double kDegenerateAccel = 2.0;  // [m/s^2] unknown, without inertial data
constexpr double kDegenerateRate = 0.5;   // [rad/s]

double square(double x) { return x * x; }

}  // namespace

void LocalGraph::reset(const Vec3& up_imu, bool at_rest) {
  P_.setZero();
  const double tilt = at_rest ? kRestTiltRad : kMovingTiltRad;
  const geometry::Mat3 vertical = up_imu * up_imu.transpose();
  const geometry::Mat3 P_tilt =
      square(tilt) * (geometry::Mat3::Identity() - vertical) + square(kYawRad) * vertical;
  P_.block<3, 3>(kR, kR) = P_tilt;
  P_.diagonal().segment<3>(kV).setConstant(square(at_rest ? kRestMps : kMovingMps));
  P_.diagonal().segment<3>(kP).setConstant(square(kPositionM));
  P_.diagonal().segment<3>(kBg).setConstant(square(at_rest ? kRestGyroBias : kMovingGyroBias));
  P_.diagonal().segment<3>(kBa).setConstant(square(kAccelBias));
  if (!at_rest) return;
  // Level was taken from the mean force, so a tilt and the bias that caused it compensate each
  // other: f = Exp(-theta) up g + b stays the measured force if b changes by -g [up]x theta.
  const geometry::Mat3 B = -kGravityMps2 * geometry::skew(up_imu);
  P_.block<3, 3>(kBa, kBa) = B * P_tilt * B.transpose();
  P_.diagonal().segment<3>(kBa).array() += square(kMeanForce);
  P_.block<3, 3>(kBa, kR) = B * P_tilt;
  P_.block<3, 3>(kR, kBa) = (B * P_tilt).transpose();
}

void LocalGraph::advance(const imu::Preintegration& pre, const imu::InertialState& before,
                         const imu::InertialState& after, const Vec3& g_odom_mps2,
                         const imu::InertialBias& bias) {
  const imu::InertialResidual r = pre.residual(before, after, g_odom_mps2, bias);
  // r = A_j dx_j + A_i dx_i + A_b db + noise = 0, solved for dx_j.
  Eigen::Matrix<double, 9, 9> A_j;
  A_j << r.d_pose_j.leftCols<3>(), r.d_velocity_j, r.d_pose_j.rightCols<3>();
  Eigen::Matrix<double, 9, 15> A_i;
  A_i << r.d_pose_i.leftCols<3>(), r.d_velocity_i, r.d_pose_i.rightCols<3>(), r.d_bias;
  const Eigen::Matrix<double, 9, 9> inverse = A_j.inverse();
  Mat15 F = Mat15::Identity();
  F.topRows<9>() = -inverse * A_i;
  P_ = (F * P_ * F.transpose()).eval();
  P_.topLeftCorner<9, 9>() += inverse * pre.covariance() * inverse.transpose();
  const double dt_s = pre.duration_s();
  P_.diagonal().segment<3>(kBg).array() += square(noise_.gyro_walk_radps2_rthz) * dt_s;
  P_.diagonal().segment<3>(kBa).array() += square(noise_.accel_walk_mps3_rthz) * dt_s;
}

void LocalGraph::advance_degenerate(double dt_s) {
  Mat15 F = Mat15::Identity();
  F.block<3, 3>(kP, kV).diagonal().setConstant(dt_s);
  P_ = (F * P_ * F.transpose()).eval();
  P_.diagonal().segment<3>(kR).array() += square(kDegenerateRate * dt_s);
  P_.diagonal().segment<3>(kV).array() += square(kDegenerateAccel * dt_s);
  P_.diagonal().segment<3>(kP).array() += square(0.5 * kDegenerateAccel * dt_s * dt_s);
}

void LocalGraph::add_registration(const Mat6& information, const Vec6& pull,
                                  imu::InertialState& state, imu::InertialBias& bias) {
  Eigen::Matrix<double, 15, 6> PS;  // columns of the pose
  PS << P_.middleCols<3>(kR), P_.middleCols<3>(kP);
  // P+ = P - P S' I (1 + S P S' I)^-1 S P: needs no inverse of I, which is singular if degenerate.
  const Mat6 gain = information * (Mat6::Identity() + pose_covariance() * information).inverse();
  P_ -= PS * gain * PS.transpose();
  P_ = (0.5 * (P_ + P_.transpose())).eval();
  PS << P_.middleCols<3>(kR), P_.middleCols<3>(kP);
  const Eigen::Matrix<double, 15, 1> d = PS * pull;
  if (!d.allFinite()) return;
  state.R_odom_imu =
      geometry::so3_normalised(state.R_odom_imu * geometry::so3_exp(d.segment<3>(kR)));
  state.v_odom_mps += d.segment<3>(kV);
  state.p_odom_m += d.segment<3>(kP);
  bias.gyro_radps += d.segment<3>(kBg);
  bias.accel_mps2 += d.segment<3>(kBa);
}

void LocalGraph::start_standstill() {
  P_.middleRows<3>(kV).setZero();
  P_.middleCols<3>(kV).setZero();
  P_.diagonal().segment<3>(kV).setConstant(square(kStandingMps));
  P_standing_ = P_;
}

void LocalGraph::know_along(const Vec3& e_odom, double shift_m, double variance_m2,
                            imu::InertialState& state, imu::InertialBias& bias) {
  const Eigen::Matrix<double, 15, 1> Ph = P_.middleCols<3>(kP) * e_odom;
  const double S = e_odom.dot(Ph.segment<3>(kP)) + variance_m2;
  if (!(S > 0.0) || !Ph.allFinite()) return;
  const Eigen::Matrix<double, 15, 1> d = Ph * (shift_m / S);
  P_ -= Ph * Ph.transpose() / S;
  P_ = (0.5 * (P_ + P_.transpose())).eval();
  state.R_odom_imu =
      geometry::so3_normalised(state.R_odom_imu * geometry::so3_exp(d.segment<3>(kR)));
  state.v_odom_mps += d.segment<3>(kV);
  bias.gyro_radps += d.segment<3>(kBg);
  bias.accel_mps2 += d.segment<3>(kBa);
}

void LocalGraph::let_accel_bias_wander(double variance_m2ps4) {
  P_.diagonal().segment<3>(kBa).array() += variance_m2ps4;
}

Mat6 LocalGraph::pose_covariance() const {
  Mat6 out;
  out << P_.block<3, 3>(kR, kR), P_.block<3, 3>(kR, kP), P_.block<3, 3>(kP, kR),
      P_.block<3, 3>(kP, kP);
  return out;
}

}  // namespace rali::odometry::paper
