#pragma once

#include "rali/graph/factors.hpp"

namespace rali::fleet {

/// A second of a level vehicle at standstill: the accelerometer reads 9.81 m/s2 upward.
inline graph::InertialFactor second_at_rest(double variance) {
  using geometry::Mat3;
  graph::InertialFactor inertial;
  inertial.duration_s = 1.0;
  inertial.dv_mps = {0.0, 0.0, 9.81};
  inertial.dp_m = {0.0, 0.0, 0.5 * 9.81};
  inertial.d_rotation_d_gyro = -Mat3::Identity();
  inertial.d_velocity_d_accel = -Mat3::Identity();
  inertial.d_position_d_accel = -0.5 * Mat3::Identity();
  inertial.covariance = variance * decltype(inertial.covariance)::Identity();
  return inertial;
}

}  // namespace rali::fleet
