#include "rali/odometry/robust/bend.hpp"

#include <cmath>

#include <Eigen/Geometry>

namespace rali::odometry {

using geometry::Mat3;
using geometry::Mat6;
using geometry::Vec3;

namespace {

/// Averages over two seconds of scans at 10 Hz: the planes change in that time, the bend does not.
constexpr double kGain = 0.05;

Vec3 up_odom(const FilterState& state) { return -state.g_odom_mps2.normalized(); }

Vec3 up_body(const FilterState& state) { return state.T_odom_body.R.transpose() * up_odom(state); }

/// Rotation per translation along the axis.
Mat3 turn_by_shift(const FilterState& state, const Vec3& axis_odom, double turn_radpm) {
  return turn_radpm * up_body(state) * axis_odom.transpose();
}

}  // namespace

void Bend::follow(const Vec3& axis_odom, double turn_radpm, double sigma_m) {
  if (!active()) here_radpm_ = turn_radpm;
  if (axis_odom.dot(axis_odom_) < 0.0) {
    here_radpm_ = -here_radpm_;
    gathered_radpm_ = -gathered_radpm_;
  }
  axis_odom_ = axis_odom;
  here_radpm_ += kGain * (turn_radpm - here_radpm_);
  const double grown = sigma_m > sigma_m_ ? 1.0 - sigma_m_ / sigma_m : 0.0;
  gathered_radpm_ += grown * (here_radpm_ - gathered_radpm_);
  sigma_m_ = sigma_m;
}

StateCov Bend::jacobian(const FilterState& state) const {
  StateCov J = StateCov::Identity();
  if (!active()) return J;
  const Mat3 turn = turn_by_shift(state, axis_odom_, here_radpm_);
  J.block<3, 3>(kTheta, kPos) = turn;
  const Vec3 along_mps = axis_odom_.dot(state.v) * axis_odom_;
  J.block<3, 3>(kVel, kPos) =
      here_radpm_ * up_odom(state).cross(along_mps) * axis_odom_.transpose();
  // The bias was fitted to the rotation along the estimated path: a faster vehicle turns faster.
  J.block<3, 3>(kGyroBias, kVel) = -turn;
  return J;
}

void Bend::move(FilterState& state, const StateVec& delta) const {
  const FilterState before = state;
  add_error(state, jacobian(before) * delta);
  const double along_m = axis_odom_.dot(delta.segment<3>(kPos));
  const double turn = here_radpm_ * along_m;
  constexpr double kStraight_rad = 1e-6;
  if (std::abs(turn) < kStraight_rad) return;
  const Vec3 up = up_odom(before);
  const Vec3 arc =
      (std::sin(turn) / turn) * axis_odom_ + ((1.0 - std::cos(turn)) / turn) * up.cross(axis_odom_);
  state.T_odom_body.p += along_m * (arc - axis_odom_);
  state.v = geometry::so3_exp(turn * up) * before.v + delta.segment<3>(kVel);
}

Mat6 Bend::turned_covariance(const FilterState& state) const {
  if (!active()) return Mat6::Zero();
  const Mat3 P = state.P.block<3, 3>(kPos, kPos);
  const double variance_m2 = axis_odom_.dot(P * axis_odom_);
  geometry::Vec6 screw = geometry::Vec6::Zero();
  screw.tail<3>() = axis_odom_;
  const Mat6 straight = variance_m2 * screw * screw.transpose();
  screw.head<3>() = gathered_radpm_ * up_body(state);
  // At two sigma, the arc deviates from its tangent by four times this.
  geometry::Vec6 beside = geometry::Vec6::Zero();
  beside.tail<3>() = 0.5 * gathered_radpm_ * variance_m2 * up_odom(state).cross(axis_odom_);
  return variance_m2 * screw * screw.transpose() - straight + beside * beside.transpose();
}

Mat6 Bend::unseen_in(const Mat6& information, const FilterState& state) const {
  if (!active()) return information;
  Mat6 across = Mat6::Identity();
  across.bottomRightCorner<3, 3>() -= axis_odom_ * axis_odom_.transpose();
  across.topRightCorner<3, 3>() = -turn_by_shift(state, axis_odom_, here_radpm_);
  return across.transpose() * information * across;
}

}  // namespace rali::odometry
