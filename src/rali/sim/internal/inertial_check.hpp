#pragma once

#include <algorithm>

#include "rali/sim/imu_model.hpp"
#include "rali/sim/trajectory.hpp"

namespace rali::sim::internal {

/// Error at the end of integrated inertial samples against ground truth.
struct Drift {
  double position_m = 0.0;
  double rotation_rad = 0.0;
  double path_m = 0.0;  ///< of the integrated interval
};

/// Integrates the exact inertial samples of a part of a trajectory (trapezoidal rule), starting
/// from the true state. For tests.
inline Drift integrate(const Trajectory& trajectory, double from_s, double span_s, double rate_hz) {
  using geometry::Vec3;
  const MotionState start = trajectory.at(from_s);
  geometry::SE3 T = start.T_world_body;
  Vec3 v = start.v_world_mps;
  const Vec3 g(0.0, 0.0, -kGravity_mps2);
  const double end_s = std::min(from_s + span_s, trajectory.duration_s());
  Drift drift;
  Vec3 last = T.p;
  for (double t = from_s; t < end_s - 1e-9;) {
    const double dt = std::min(1.0 / rate_hz, end_s - t);
    const sensor::ImuSample a = ideal_imu({}, trajectory.at(t), {});
    const sensor::ImuSample b = ideal_imu({}, trajectory.at(t + dt), {});
    const geometry::Mat3 R = T.R * geometry::so3_exp(0.5 * dt * (a.gyro_radps + b.gyro_radps));
    const Vec3 accel = 0.5 * (T.R * a.accel_mps2 + R * b.accel_mps2) + g;
    T = {R, T.p + v * dt + 0.5 * dt * dt * accel};
    v += dt * accel;
    t += dt;
    const Vec3 p = trajectory.pose_at(t).p;
    drift.path_m += (p - last).norm();
    last = p;
  }
  const geometry::SE3 truth = trajectory.pose_at(end_s);
  drift.position_m = (T.p - truth.p).norm();
  drift.rotation_rad = geometry::so3_log(T.R.transpose() * truth.R).norm();
  return drift;
}

}  // namespace rali::sim::internal
