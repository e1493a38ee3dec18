#include "rali/imu/kinematics.hpp"

namespace rali::imu {

using geometry::Mat3;
using geometry::so3_exp;
using geometry::Vec3;

void integrate(KinematicState& state, const Vec3& w_radps, const Vec3& a_mps2,
               const Vec3& g_odom_mps2, double dt_s) {
  const Mat3 half = so3_exp(0.5 * dt_s * w_radps);
  const Mat3 R_mid = state.T_odom_body.R * half;
  const Vec3 a_odom = R_mid * a_mps2 + g_odom_mps2;
  state.T_odom_body.p += dt_s * state.v_odom_mps + 0.5 * dt_s * dt_s * a_odom;
  state.v_odom_mps += dt_s * a_odom;
  state.T_odom_body.R = R_mid * half;
}

}  // namespace rali::imu
