#include <algorithm>
#include <cmath>
#include <limits>

#include "rali/base/assert.hpp"
#include "rali/geometry/regression.hpp"
#include "rali/odometry/robust/internal/robust_filter.hpp"

namespace rali::odometry::internal {

using geometry::Mat3;
using geometry::Vec3;

namespace {

/// A measurement that arrives after the scan that covers it is predicted from the current state at
/// constant speed: half a scan of acceleration over this time is a millimetre.
constexpr double kLateMax_s = 0.1;

/// Derivative of a measurement by the whole state. Without inertial data the state's velocity is in
/// the body frame and rotates with it.
Eigen::Matrix<double, 1, kStateDim> row_of(const AugmentedMeasurement& m, const FilterState& state,
                                           bool inertial) {
  Eigen::Matrix<double, 1, kStateDim> H = Eigen::Matrix<double, 1, kStateDim>::Zero();
  H.segment<6>(kTheta) = m.d_pose;
  H.segment<3>(kVel) = m.d_velocity;
  if (!inertial) {
    const Mat3& R = state.T_odom_body.R;
    H.segment<3>(kVel) = m.d_velocity * R;
    H.segment<3>(kTheta) -= m.d_velocity * R * geometry::skew(state.v);
  }
  return H;
}

/// Covariance of the state followed by the augmented states.
Eigen::MatrixXd joint_covariance(const FilterState& state) {
  const int n = state.augmented.size();
  Eigen::MatrixXd P(kStateDim + n, kStateDim + n);
  P.topLeftCorner<kStateDim, kStateDim>() = state.P;
  P.topRightCorner(kStateDim, n) = state.P_augmented;
  P.bottomLeftCorner(n, kStateDim) = state.P_augmented.transpose();
  P.bottomRightCorner(n, n) = state.augmented.covariance;
  return P;
}

}  // namespace

std::optional<Moment> RobustOdometry::advance_to(Time t) {
  const bool found_itself = started_ && (inertial_ || !has_imu_);
  const double ago_s = (state_.t - t).s();
  if (!found_itself || ago_s > kLateMax_s) return std::nullopt;
  if (!at_standstill_) predict(t);
  Moment now;
  now.t = t;
  now.T_odom_body = state_.T_odom_body;
  now.at_rest = at_standstill_;
  if (at_standstill_) return now;
  now.v_odom_mps = inertial_ ? state_.v : Vec3(state_.T_odom_body.R * state_.v);
  now.w_body_radps = state_.gyro_bias_radps;
  if (has_imu_ && !imu_.empty()) now.w_body_radps = imu_.at(t).gyro_radps - state_.gyro_bias_radps;
  if (ago_s > 0.0) {
    now.T_odom_body.R = now.T_odom_body.R * geometry::so3_exp(-ago_s * now.w_body_radps);
    now.T_odom_body.p -= ago_s * now.v_odom_mps;
  }
  return now;
}

int RobustOdometry::add_states(const AugmentedStates::Vector& mean,
                               const AugmentedStates::Matrix& covariance,
                               const AugmentedRowList& rows) {
  const int first = state_.augmented.size();
  const auto n = static_cast<int>(mean.size());
  RALI_ASSERT(rows.empty() || static_cast<int>(rows.size()) == n);
  if (first + n > AugmentedStates::kMax) return -1;
  const Eigen::MatrixXd H = joint_rows(rows);
  AugmentedStates::Matrix own = covariance;
  Eigen::MatrixXd cross = Eigen::MatrixXd::Zero(kStateDim + first, n);
  if (!rows.empty()) {
    cross = joint_covariance(state_) * H.transpose();
    own += H * cross;
  }
  AugmentedStates& augmented = state_.augmented;
  augmented.mean.conservativeResize(first + n);
  augmented.mean.tail(n) = mean;
  augmented.covariance.conservativeResize(first + n, first + n);
  augmented.covariance.topRightCorner(first, n) = cross.bottomRows(first);
  augmented.covariance.bottomLeftCorner(n, first) = cross.bottomRows(first).transpose();
  augmented.covariance.bottomRightCorner(n, n) = own;
  state_.P_augmented.conservativeResize(kStateDim, first + n);
  state_.P_augmented.rightCols(n) = cross.topRows<kStateDim>();
  return first;
}

void RobustOdometry::remove_states(int first, int n) {
  AugmentedStates& augmented = state_.augmented;
  const int size = augmented.size();
  RALI_ASSERT(first >= 0 && n >= 0 && first + n <= size);
  const int behind = size - first - n;
  augmented.mean.segment(first, behind) = augmented.mean.tail(behind).eval();
  augmented.covariance.middleRows(first, behind) = augmented.covariance.bottomRows(behind).eval();
  augmented.covariance.middleCols(first, behind) = augmented.covariance.rightCols(behind).eval();
  state_.P_augmented.middleCols(first, behind) = state_.P_augmented.rightCols(behind).eval();
  augmented.mean.conservativeResize(size - n);
  augmented.covariance.conservativeResize(size - n, size - n);
  state_.P_augmented.conservativeResize(kStateDim, size - n);
}

void RobustOdometry::walk_side(int index, double variance) {
  state_.augmented.covariance(index, index) += variance;
}

double RobustOdometry::variance(const AugmentedMeasurement& m) const {
  const Eigen::Matrix<double, 1, kStateDim> H =
      row_of(m, state_, inertial_) * bend_.jacobian(state_);
  const double map = (m.d_pose * drift_.map_error() * m.d_pose.transpose()).value();
  double out = map + (H * state_.P * H.transpose()).value();
  if (m.d_augmented.size() > 0) {
    out += 2.0 * (H * state_.P_augmented * m.d_augmented).value() +
           m.d_augmented.dot(state_.augmented.covariance * m.d_augmented);
  }
  return out;
}

Vec3 RobustOdometry::apply(const AugmentedMeasurement& m, double R) {
  const Eigen::Matrix<double, 1, kStateDim> H =
      row_of(m, state_, inertial_) * bend_.jacobian(state_);
  StateVec PH = state_.P * H.transpose();
  if (m.d_augmented.size() > 0) PH += state_.P_augmented * m.d_augmented;
  const AugmentedStates::Vector augmented_PH =
      state_.P_augmented.transpose() * H.transpose() + state_.augmented.covariance * m.d_augmented;
  // The map's own error is part of the innovation but not estimated (Schmidt 1966): it is noise.
  const double S = variance(m) + R;
  const StateVec shift = PH * (m.residual / S);
  state_.P -= PH * PH.transpose() / S;
  state_.P = 0.5 * (state_.P + state_.P.transpose()).eval();
  if (m.d_augmented.size() > 0) {
    AugmentedStates::Vector moved = augmented_PH;
    if (m.considered >= 0) {
      moved.segment<3>(m.considered) = m.estimates * augmented_PH.segment<3>(m.considered);
    }
    state_.P_augmented -= PH * augmented_PH.transpose() / S;
    state_.augmented.covariance -= (moved * augmented_PH.transpose() +
                                    augmented_PH * moved.transpose() - moved * moved.transpose()) /
                                   S;
    state_.augmented.mean += moved * (m.residual / S);
  }
  const FilterState before = state_;
  bend_.move(state_, shift);
  move_history(before);
  uncertainty_across(shift.segment<3>(kPos));
  return shift.segment<3>(kPos);
}

/// The poses since the last scan move with the newest one, bent by the change of speed: a scan
/// undistorted along them stays consistent whenever a range arrived within it.
void RobustOdometry::move_history(const FilterState& before) {
  const geometry::SE3 T_new_old = state_.T_odom_body * before.T_odom_body.inverse();
  const Vec3 dv = inertial_ ? Vec3(state_.v - before.v) : Vec3::Zero();
  for (TimedPose& pose : poses_) {
    pose.T_odom_body = T_new_old * pose.T_odom_body;
    pose.T_odom_body.p -= dv * (state_.t - pose.t).s();
  }
}

/// A tunnel is not as straight as the long axis of the covariance. After a correction of metres the
/// walls are off by centimetres, and the filter, whose lateral sigma is millimetres, would explain
/// that by biases.
void RobustOdometry::uncertainty_across(const Vec3& shift_m) {
  const UpdateSettings& u = settings_.update;
  const double off_m = u.shift_slope * (shift_m.norm() - u.straight_m);
  if (!(off_m > 0.0)) return;
  const Vec3 d = shift_m.normalized();
  state_.P.block<3, 3>(kPos, kPos) += off_m * off_m * (Mat3::Identity() - d * d.transpose());
}

Eigen::MatrixXd RobustOdometry::joint_rows(const AugmentedRowList& rows) const {
  const int n = state_.augmented.size();
  const StateCov J = bend_.jacobian(state_);
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(static_cast<int>(rows.size()), kStateDim + n);
  for (int k = 0; k < H.rows(); ++k) {
    const AugmentedMeasurement& row = rows[static_cast<std::size_t>(k)];
    H.row(k).head<kStateDim>() = row_of(row, state_, inertial_) * J;
    if (row.d_augmented.size() > 0) H.row(k).tail(n) = row.d_augmented.transpose();
  }
  return H;
}

AugmentedStates::Matrix RobustOdometry::covariance(const AugmentedRowList& rows) const {
  const Eigen::MatrixXd H = joint_rows(rows);
  return H * joint_covariance(state_) * H.transpose();
}

Vec3 RobustOdometry::replace(const AugmentedRowList& rows, const AugmentedStates::Vector& shift,
                             const AugmentedStates::Matrix& covariance) {
  const Eigen::MatrixXd H = joint_rows(rows);
  Eigen::MatrixXd P = joint_covariance(state_);
  const Eigen::MatrixXd PHt = P * H.transpose();
  const AugmentedStates::Matrix known = H * PHt;
  const Eigen::MatrixXd K = geometry::regression(PHt, known);
  P += (K * (covariance - known) * K.transpose()).eval();
  P = (0.5 * (P + P.transpose())).eval();
  const int n = state_.augmented.size();
  state_.P = P.topLeftCorner<kStateDim, kStateDim>();
  state_.P_augmented = P.topRightCorner(kStateDim, n);
  state_.augmented.covariance = P.bottomRightCorner(n, n);
  const Eigen::VectorXd moved = K * shift;
  state_.augmented.mean += moved.tail(n);
  const StateVec own = moved.head<kStateDim>();
  const FilterState before = state_;
  bend_.move(state_, own);
  move_history(before);
  uncertainty_across(own.segment<3>(kPos));
  return own.segment<3>(kPos);
}

int RobustOdometry::surfaces_between(const Vec3& p_odom_m, const Vec3& q_odom_m) const {
  const double step_m = 0.25 * settings_.map.voxel_m;
  const Vec3 line = q_odom_m - p_odom_m;
  const double length_m = line.norm();
  const int steps = std::max(1, static_cast<int>(length_m / step_m));
  const Vec3 step = line / steps;
  int surfaces = 0;
  Vec3 last_crossing = p_odom_m;
  for (int k = 0; k < steps; ++k) {
    const Vec3 a = p_odom_m + k * step;
    const int index = map_.find(a + 0.5 * step);
    if (index < 0) continue;
    const Plane& plane = map_.plane(index);
    const double before = plane.n.dot(a - plane.q);
    const double after = plane.n.dot(a + step - plane.q);
    if (before * after > 0.0) continue;
    const bool other = surfaces == 0 || (a - last_crossing).norm() > settings_.map.voxel_m;
    if (other) ++surfaces;
    last_crossing = a;
  }
  return surfaces;
}

void RobustOdometry::widen(double factor) {
  // Only along degenerate directions: the LiDAR constrains the others.
  for (int k = 0; k < 3; ++k) {
    if (!degenerate_[static_cast<std::size_t>(k)]) continue;
    const Vec3 d = axes_.col(k);
    const auto add = [&](int block, const Vec3& axis, double sigma_max) {
      const double variance = axis.dot(state_.P.block<3, 3>(block, block) * axis);
      const double wider = std::min(factor * variance, sigma_max * sigma_max);
      if (wider <= variance) return;
      state_.P.block<3, 3>(block, block) += (wider - variance) * axis * axis.transpose();
    };
    add(kPos, d, std::numeric_limits<double>::infinity());
    // Without a velocity estimate, the velocity prior is N(0, start_speed_mps^2). Without this
    // bound, ranges that fit nothing gave a vehicle at standstill a speed of 16 m/s.
    add(kVel, inertial_ ? d : Vec3(state_.T_odom_body.R.transpose() * d),
        settings_.constant_velocity.start_speed_mps);
  }
}

}  // namespace rali::odometry::internal
