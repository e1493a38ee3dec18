#include "rali/graph/values.hpp"

namespace rali::graph {

KeyframeState boxplus(const KeyframeState& x, const StateVec& delta) {
  KeyframeState y;
  y.T_odom_body = geometry::boxplus(x.T_odom_body, delta.head<6>());
  // Hundreds of steps multiply hundreds of rotations: this removes their rounding.
  y.T_odom_body.R = geometry::so3_normalised(y.T_odom_body.R);
  y.v_odom_mps = x.v_odom_mps + delta.segment<3>(kVel);
  y.gyro_bias_radps = x.gyro_bias_radps + delta.segment<3>(kGyroBias);
  y.accel_bias_mps2 = x.accel_bias_mps2 + delta.segment<3>(kAccelBias);
  return y;
}

StateVec boxminus(const KeyframeState& b, const KeyframeState& a) {
  StateVec delta;
  delta << geometry::boxminus(b.T_odom_body, a.T_odom_body), b.v_odom_mps - a.v_odom_mps,
      b.gyro_bias_radps - a.gyro_bias_radps, b.accel_bias_mps2 - a.accel_bias_mps2;
  return delta;
}

StateMat boxminus_jacobian(const StateVec& delta) {
  StateMat J = StateMat::Identity();
  J.block<3, 3>(kTheta, kTheta) = geometry::so3_right_jacobian_inverse(delta.segment<3>(kTheta));
  return J;
}

}  // namespace rali::graph
