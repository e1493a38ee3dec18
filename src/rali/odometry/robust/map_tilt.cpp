#include "rali/odometry/robust/map_tilt.hpp"

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

namespace rali::odometry {

using geometry::Mat3;
using geometry::Vec3;

void begin_tilt(FilterState& state, const TiltRate& rate) {
  state.g_first_odom_mps2 = state.g_odom_mps2;
  state.tilt_radpm = 0.0;
  decorrelate(state, kFirstGravity, 3);
  StateCov same = StateCov::Identity();
  same.block<2, 2>(kFirstGravity, kGravity).setIdentity();
  propagate_covariance(state, same);
  state.P(kTiltRate, kTiltRate) = rate.sigma_radpm * rate.sigma_radpm;
}

void scale_tilt(FilterState& state, double factor) {
  state.P.row(kTiltRate) *= factor;
  state.P.col(kTiltRate) *= factor;
  state.P_augmented.row(kTiltRate) *= factor;
  state.tilt_radpm *= factor;
}

void tilt_with_map(FilterState& state, const Vec3& moved_odom_m, const TiltRate& rate) {
  const Vec3 across_m = -state.g_odom_mps2.normalized().cross(moved_odom_m);
  const double kept = std::exp(-across_m.norm() / rate.length_m);
  StateCov F = StateCov::Identity();
  F.block<3, 1>(kTheta, kTiltRate) = state.T_odom_body.R.transpose() * across_m;
  F.block<3, 1>(kVel, kTiltRate) = across_m.cross(state.v);
  F.block<2, 1>(kGravity, kTiltRate) = gravity_basis(state.g_odom_mps2).transpose() * across_m;
  F(kTiltRate, kTiltRate) = kept;
  propagate_covariance(state, F);
  state.P(kTiltRate, kTiltRate) += (1.0 - kept * kept) * rate.sigma_radpm * rate.sigma_radpm;

  const Mat3 turn = geometry::so3_exp(state.tilt_radpm * across_m);
  state.T_odom_body.R = turn * state.T_odom_body.R;
  state.v = turn * state.v;
  state.g_odom_mps2 = turn * state.g_odom_mps2;
  state.tilt_radpm *= kept;
}

Eigen::Vector2d map_tilt_rad(const FilterState& state) {
  constexpr double kNumerical_rad = 1e-6;
  const Vec3 turn =
      geometry::so3_log(geometry::rotation_between(state.g_first_odom_mps2, state.g_odom_mps2));
  const Eigen::Vector2d across = gravity_basis(state.g_odom_mps2).transpose() * turn;
  Eigen::Matrix<double, 2, kStateDim> H = Eigen::Matrix<double, 2, kStateDim>::Zero();
  H.block<2, 2>(0, kGravity).setIdentity();
  H.block<2, 2>(0, kFirstGravity) = -Eigen::Matrix2d::Identity();
  Eigen::Matrix2d P = H * state.P * H.transpose();
  P.diagonal().array() += kNumerical_rad * kNumerical_rad;
  const double chi2 = across.dot(P.llt().solve(across));
  if (!(chi2 > 2.0)) return Eigen::Vector2d::Zero();
  return (1.0 - 2.0 / chi2) * turn.head<2>();
}

}  // namespace rali::odometry
