#include "rali/vehicle/inertial_factor.hpp"

#include <algorithm>

namespace rali::vehicle {

namespace {

/// Smallest random walk of a bias: zero, if set by the user, would make a solver divide by zero.
constexpr double kWalkMin = 1e-9;

}  // namespace

graph::InertialFactor inertial_factor(const imu::Preintegration& sum,
                                      const odometry::ImuNoiseSettings& noise,
                                      const geometry::SE3& T_body_imu) {
  const imu::InertialBias& bias = sum.bias();
  graph::InertialFactor f;
  f.duration_s = sum.duration_s();
  f.dR = sum.delta_rotation(bias);
  f.dv_mps = sum.delta_velocity_mps(bias);
  f.dp_m = sum.delta_position_m(bias);
  f.gyro_bias_radps = bias.gyro_radps;
  f.accel_bias_mps2 = bias.accel_mps2;
  f.d_rotation_d_gyro = sum.d_rotation_d_gyro();
  f.d_velocity_d_gyro = sum.d_velocity_d_gyro();
  f.d_velocity_d_accel = sum.d_velocity_d_accel();
  f.d_position_d_gyro = sum.d_position_d_gyro();
  f.d_position_d_accel = sum.d_position_d_accel();
  f.covariance = sum.covariance();
  f.gyro_walk_radps_rts = std::max(noise.gyro_walk_radps2_rthz, kWalkMin);
  f.accel_walk_mps2_rts = std::max(noise.accel_walk_mps3_rthz, kWalkMin);
  f.T_body_imu = T_body_imu;
  return f;
}

}  // namespace rali::vehicle
