#pragma once

#include "rali/base/rng.hpp"
#include "rali/geometry/so3.hpp"
#include "rali/graph/window.hpp"

namespace rali::graph {

/// `scale` times three standard normal numbers.
inline geometry::Vec3 random_vec3(Rng& rng, double scale) {
  const double x = rng.normal();
  const double y = rng.normal();
  const double z = rng.normal();
  return scale * geometry::Vec3(x, y, z);
}

/// Two keyframes about 2 m apart at any attitude, landmark 1, bias 2 and tau 3.
inline Window random_window(Rng& rng) {
  Window window;
  for (Seq seq = 4; seq < 6; ++seq) {
    KeyframeNode node;
    node.seq = seq;
    node.x.T_odom_body = {geometry::so3_exp(random_vec3(rng, 0.8)), random_vec3(rng, 2.0)};
    node.x.v_odom_mps = random_vec3(rng, 1.0);
    node.x.gyro_bias_radps = random_vec3(rng, 0.02);
    node.x.accel_bias_mps2 = random_vec3(rng, 0.2);
    window.keyframes.push_back(node);
  }
  for (const GlobalId id : {landmark_id(1), bias_id(2), tau_id(3)}) {
    GlobalNode node;
    node.id = id;
    node.value = random_vec3(rng, id.kind == GlobalKind::kLandmark ? 5.0 : 0.1);
    node.prior_mean = random_vec3(rng, 0.5);
    node.prior_information = geometry::Vec3(4.0, 9.0, 1.0).asDiagonal();
    window.globals.push_back(node);
  }
  window.lay_out();
  return window;
}

/// Deltas near those of the two keyframes of random_window.
inline InertialFactor random_inertial(Rng& rng) {
  InertialFactor f;
  f.i = 4;
  f.j = 5;
  f.duration_s = 0.8;
  f.dR = geometry::so3_exp(random_vec3(rng, 0.5));
  f.dv_mps = random_vec3(rng, 1.0);
  f.dp_m = random_vec3(rng, 1.0);
  f.gyro_bias_radps = random_vec3(rng, 0.02);
  f.accel_bias_mps2 = random_vec3(rng, 0.2);
  for (geometry::Mat3* J : {&f.d_rotation_d_gyro, &f.d_velocity_d_gyro, &f.d_velocity_d_accel,
                            &f.d_position_d_gyro, &f.d_position_d_accel}) {
    for (int c = 0; c < 3; ++c) J->col(c) = random_vec3(rng, 0.5);
  }
  f.gyro_walk_radps_rts = 0.1;
  f.accel_walk_mps2_rts = 0.3;
  f.T_body_imu = {geometry::so3_exp(random_vec3(rng, 0.5)), random_vec3(rng, 0.3)};
  return f;
}

}  // namespace rali::graph
