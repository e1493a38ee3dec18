#pragma once

#include "rali/imu/preintegration.hpp"
#include "rali/odometry/imu_noise.hpp"

namespace rali::odometry::paper {

/// The paper's local pose graph, reduced to its newest pose: one preintegration factor from the
/// previous pose, one registration factor, older poses marginalised. For this chain the graph's
/// solution is a Kalman filter over (rotation, velocity, position, gyro bias, accelerometer bias).
/// Source: paper, section "System Overview"; residual: docs/explain/math/imu.md.
class LocalGraph {
 public:
  explicit LocalGraph(const ImuNoiseSettings& noise) : noise_(noise) {}

  /// Resets the graph. Odom is defined by the first pose: yaw and position are exact.
  /// @param up_imu unit vector against gravity in the IMU's frame
  /// @param at_rest level and gyro bias were estimated at standstill
  void reset(const geometry::Vec3& up_imu, bool at_rest);

  /// Propagates the covariance over one preintegration factor.
  void advance(const imu::Preintegration& pre, const imu::InertialState& before,
               const imu::InertialState& after, const geometry::Vec3& g_odom_mps2,
               const imu::InertialBias& bias);

  /// The same without inertial samples: constant velocity with large noise.
  void advance_degenerate(double dt_s);

  /// Adds a registration factor: cost d^T information d/2 - d^T pull in the deviation d from
  /// `state`, of the IMU's pose in boxplus order (rotation, position). Moves state and bias.
  void add_registration(const geometry::Mat6& information, const geometry::Vec6& pull,
                        imu::InertialState& state, imu::InertialBias& bias);

  /// Start of a standstill: the velocity is zero, whatever the estimate was.
  void start_standstill();

  /// Standstill continues: the covariance is that of its start.
  void stay() { P_ = P_standing_; }

  /// A measurement of this variance moved the position by shift_m along e_odom. Velocity, attitude
  /// and biases follow by their correlation with the position.
  void know_along(const geometry::Vec3& e_odom, double shift_m, double variance_m2,
                  imu::InertialState& state, imu::InertialBias& bias);

  void let_accel_bias_wander(double variance_m2ps4);

  /// Covariance of the IMU's pose, boxplus order.
  [[nodiscard]] geometry::Mat6 pose_covariance() const;

  using Mat15 = Eigen::Matrix<double, 15, 15>;

  /// Covariance of the IMU's rotation, velocity, position, and the biases of gyro and
  /// accelerometer.
  [[nodiscard]] const Mat15& covariance() const { return P_; }

 private:
  ImuNoiseSettings noise_;
  Mat15 P_ = Mat15::Zero();
  Mat15 P_standing_ = Mat15::Zero();
};

}  // namespace rali::odometry::paper
