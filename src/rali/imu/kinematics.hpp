#pragma once

#include "rali/geometry/se3.hpp"

namespace rali::imu {

/// Pose and velocity of the body in odom at one instant.
struct KinematicState {
  geometry::SE3 T_odom_body;
  geometry::Vec3 v_odom_mps = geometry::Vec3::Zero();
};

/// Advances by dt_s with constant body rate w [rad/s] and specific force a [m/s^2], both without
/// bias. The force is rotated by the attitude at mid-interval (algorithms 1.2): with that at its
/// start, dv would be wrong by 1.2 mm/s after 1 s at 0.5 rad/s.
void integrate(KinematicState& state, const geometry::Vec3& w_radps, const geometry::Vec3& a_mps2,
               const geometry::Vec3& g_odom_mps2, double dt_s);

}  // namespace rali::imu
