#include <cmath>

#include "rali/geometry/so3.hpp"
#include "rali/odometry/robust/internal/robust_filter.hpp"

namespace rali::odometry::internal {

using geometry::Vec3;

/// Without inertial data only the scans measure the rotation of the vehicle.
void RobustOdometry::follow_bend(const UpdateResult& done) {
  const auto axis = degenerate_axis();
  if (!axis || !inertial_) return bend_.end();
  if (done.matches < settings_.update.matches_min) return;
  const double variance_m2 = axis->dot(state_.P.block<3, 3>(kPos, kPos) * *axis);
  bend_.follow(*axis, done.bend_radpm, std::sqrt(variance_m2));
}

/// The gyro's bias, where scans or standstill determine it. In a degenerate bend the bias in the
/// state follows the speed (Bend), and for a while afterwards.
void RobustOdometry::know_gyro_bias() {
  turn_speed_.know(state_.gyro_bias_radps, state_.P.block<3, 3>(kGyroBias, kGyroBias));
}

/// The gyro's turn in a bend measures the speed along the degenerate axis.
/// @param inertial from the last scan to this one
void RobustOdometry::measure_turn_speed(const InertialIntegral& inertial) {
  if (!inertial_) return;
  const auto axis = degenerate_axis();
  if (!axis || !bend_.active()) {
    const bool seen_for_long = !t_seen_ || (state_.t - *t_seen_).s() > kGlimpse_s;
    const bool all_seen = !degenerate_[0] && !degenerate_[1] && !degenerate_[2];
    return all_seen && seen_for_long ? know_gyro_bias() : turn_speed_.interrupt();
  }
  if (!turn_speed_.bias_radps()) return;
  const FilterState& last = last_posterior_;
  const Vec3 up_body = -(last.T_odom_body.R.transpose() * state_.g_odom_mps2).normalized();
  const double measured_rad = up_body.dot(geometry::so3_log(inertial.dR));
  const Vec3 corrected = geometry::so3_log(T_predicted_.R.transpose() * state_.T_odom_body.R);
  TurnSpeed::Step step;
  step.span_s = seconds_between(last.t, state_.t);
  step.gyro_rad =
      measured_rad + step.span_s * up_body.dot(last.gyro_bias_radps - *turn_speed_.bias_radps());
  step.turn_rad = measured_rad + up_body.dot(corrected);
  step.way_m = axis->dot(last.v * step.span_s + inertial.dp_m);
  step.correction_mps = axis->dot(state_.v - last.v - inertial.dv_mps);
  step.bend_radpm = bend_.here_radpm();
  step.gyro_noise_radps_rthz = process_noise().gyro_radps_rthz;
  const auto measured = turn_speed_.add(step, up_body);
  if (!measured) return;
  AugmentedMeasurement m;
  m.d_velocity = measured->rate_radpmps * axis->transpose();
  m.residual = measured->residual_rad;
  m.d_augmented = AugmentedStates::Vector::Zero(state_.augmented.size());
  apply(m, measured->variance_rad2);
}

/// At standstill the gyro measures its own bias. The one in the state has followed the speed
/// through the bend (Bend): it is off by as much as that was, or as the bias known before says.
void RobustOdometry::doubt_bias_in_bend() {
  const auto axis = degenerate_axis();
  if (!axis || !bend_.active()) return;
  const Vec3 up_body = -(state_.T_odom_body.R.transpose() * state_.g_odom_mps2).normalized();
  const double speed_m2ps2 = axis->dot(state_.P.block<3, 3>(kVel, kVel) * *axis);
  const double bend_radpm =
      std::max(std::abs(bend_.here_radpm()), std::abs(bend_.gathered_radpm()));
  const auto& known = turn_speed_.bias_radps();
  const double off_radps = known ? up_body.dot(*known - state_.gyro_bias_radps) : 0.0;
  state_.P.block<3, 3>(kGyroBias, kGyroBias) +=
      (bend_radpm * bend_radpm * speed_m2ps2 + off_radps * off_radps) * up_body *
      up_body.transpose();
}

/// The bias that a standstill in a degenerate bend has shown, if it is better known than before.
void RobustOdometry::know_bias_at_standstill() {
  const Vec3 up_body = -(state_.T_odom_body.R.transpose() * state_.g_odom_mps2).normalized();
  const double variance = up_body.dot(state_.P.block<3, 3>(kGyroBias, kGyroBias) * up_body);
  const bool worse =
      bend_.active() && turn_speed_.bias_radps() && variance > turn_speed_.bias_variance(up_body);
  return worse ? turn_speed_.interrupt() : know_gyro_bias();
}

}  // namespace rali::odometry::internal
