#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "rali/base/time.hpp"
#include "rali/graph/values.hpp"

namespace rali::graph {

/// Running number of a keyframe, ascending.
using Seq = std::uint32_t;

/// Inertial deltas between keyframes i and j, both live (algorithms 1.3, Forster et al. 2017). The
/// fields are those of imu::Preintegration; rows and covariance are (rotation, velocity, position)
/// of the IMU.
struct InertialFactor {
  Seq i = 0;
  Seq j = 0;
  double duration_s = 0.0;
  geometry::Mat3 dR = geometry::Mat3::Identity();
  geometry::Vec3 dv_mps = geometry::Vec3::Zero();
  geometry::Vec3 dp_m = geometry::Vec3::Zero();
  geometry::Vec3 gyro_bias_radps = geometry::Vec3::Zero();  ///< used in the integration
  geometry::Vec3 accel_bias_mps2 = geometry::Vec3::Zero();
  geometry::Mat3 d_rotation_d_gyro = geometry::Mat3::Zero();
  geometry::Mat3 d_velocity_d_gyro = geometry::Mat3::Zero();
  geometry::Mat3 d_velocity_d_accel = geometry::Mat3::Zero();
  geometry::Mat3 d_position_d_gyro = geometry::Mat3::Zero();
  geometry::Mat3 d_position_d_accel = geometry::Mat3::Zero();
  Eigen::Matrix<double, 9, 9> covariance = Eigen::Matrix<double, 9, 9>::Identity();
  double gyro_walk_radps_rts = 1e-5;  ///< bias random walk: sigma is this times sqrt(duration)
  double accel_walk_mps2_rts = 1e-4;
  geometry::Vec3 g_odom_mps2 = geometry::Vec3(0.0, 0.0, -9.81);
  geometry::SE3 T_body_imu;
};

/// Relative pose from LiDAR: residual (Log(Rm^T Ri^T Rj), Ri^T (pj - pi) - pm), algorithms 6.1.
struct RelativePoseFactor {
  Seq i = 0;
  Seq j = 0;
  geometry::SE3 T_i_j;
  /// Of that residual: rotation in j, translation in i. May be singular: a degenerate direction has
  /// zero information, and that stays zero (algorithms 6.2).
  geometry::Mat6 information = geometry::Mat6::Zero();
};

/// A loop closure: two nodes that see the same place, possibly wrong (algorithms_fleet 8.4).
struct LoopFactor {
  std::uint64_t id = 0;
  RelativePoseFactor pose;
};

/// An antenna between two keyframes: p = (1 - alpha) T_i p_i + alpha T_j p_j, where p_i and p_j are
/// the antenna at the time of measurement, transformed by the odometry into the bodies of i and j.
struct RangeEnd {
  Seq i = 0;
  std::optional<Seq> j;  ///< absent: the antenna depends on i alone, alpha must be 0
  double alpha = 0.0;
  geometry::Vec3 p_i_m = geometry::Vec3::Zero();
  geometry::Vec3 p_j_m = geometry::Vec3::Zero();
};

/// One range, used once (algorithms 4.1, 5.4), as measured at this end.
struct RangeFactor : RangeEnd {
  std::uint64_t id = 0;  ///< of the measurement, never reused
  Time t;                ///< of the measurement
  /// The other end: nodes too, a landmark, or else a point without error. A point with an error
  /// must be a landmark, because its error is common to all its ranges.
  std::optional<RangeEnd> other;
  std::optional<int> landmark;
  geometry::Vec3 p_fixed_odom_m = geometry::Vec3::Zero();
  std::optional<int> bias;
  std::optional<int> tau;
  /// d range/dt, which multiplies tau; absent: computed from the velocities of the keyframes, which
  /// they must have.
  std::optional<double> range_rate_mps;
  double range_m = 0.0;
  double sigma_m = 0.1;
  double weight = 1.0;  ///< multiplies the information (one-sided weight of algorithms 4.3)
};

/// Standstill of the vehicle: v_i = 0 if it has a velocity, and with `next` also T_i = T_next
/// (algorithms 2.6).
struct StandstillFactor {
  Seq i = 0;
  std::optional<Seq> next;
  double sigma_mps = 0.01;
  double sigma_m = 0.003;
  double sigma_rad = 8.7266e-4;  ///< 0.05 deg
};

/// R^T e_z - up = 0: the direction of gravity in a body at standstill (algorithms_fleet 8.1).
struct GravityFactor {
  Seq i = 0;
  geometry::Vec3 up_body = geometry::Vec3::UnitZ();  ///< unit vector
  double sigma_rad = 8.7266e-3;                      ///< 0.5 deg
};

/// Prior of one keyframe; its information may be singular. For a node that is only a pose, only the
/// pose's part is used.
struct PriorFactor {
  Seq i = 0;
  KeyframeState mean;
  StateMat information = StateMat::Zero();
};

}  // namespace rali::graph
