#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/LU>
#include <fmt/format.h>

#include "rali/odometry/robust/internal/robust_filter.hpp"

namespace rali::odometry::internal {

using geometry::Mat3;
using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;
using sensor::LidarScan;

namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180.0;
/// After this many scans of driving the noise counts as measured.
constexpr int kDriven = 10;

/// Lower bound of the noise before driving, as a fraction of the noise typical while driving,
/// whatever the samples show: the bias wanders as well.
constexpr double kMin = 1.0 / 3.0;

}  // namespace

ProcessNoise RobustOdometry::process_noise() const {
  imu::NoiseDensity density = motion_noise_.density();
  if (driven_scans_ < kDriven) {
    // Noise measured at standstill lacks the part from driving, and a start comes without warning.
    const imu::NoiseDensity rest = standstill_.rest_density().value_or(imu::NoiseDensity{0.0, 0.0});
    const imu::MotionNoiseSettings& typical = settings_.motion_noise;
    density.gyro_radps_rthz = std::max(
        {density.gyro_radps_rthz, kMin * typical.gyro_typical_radps_rthz, rest.gyro_radps_rthz});
    density.accel_mps2_rthz = std::max(
        {density.accel_mps2_rthz, kMin * typical.accel_typical_mps2_rthz, rest.accel_mps2_rthz});
  }
  ProcessNoise noise;
  noise.gyro_radps_rthz = noise_boost_ * density.gyro_radps_rthz;
  noise.accel_mps2_rthz = noise_boost_ * density.accel_mps2_rthz;
  noise.gyro_walk = noise_.gyro_walk_radps2_rthz;
  noise.accel_walk = noise_.accel_walk_mps3_rthz;
  return noise;
}

/// At standstill only the sensor's own noise counts, without the part from driving: as measured at
/// standstill, or typical before.
ProcessNoise RobustOdometry::rest_noise() const {
  ProcessNoise noise = process_noise();
  const imu::MotionNoiseSettings& typical = settings_.motion_noise;
  const imu::NoiseDensity rest = standstill_.rest_density().value_or(
      imu::NoiseDensity{typical.gyro_typical_radps_rthz, typical.accel_typical_mps2_rthz});
  noise.gyro_radps_rthz =
      std::min(noise.gyro_radps_rthz,
               std::max(kMin * typical.gyro_typical_radps_rthz, rest.gyro_radps_rthz));
  noise.accel_mps2_rthz =
      std::min(noise.accel_mps2_rthz,
               std::max(kMin * typical.accel_typical_mps2_rthz, rest.accel_mps2_rthz));
  return noise;
}

/// Compares the LiDAR's motion since the last scan with that of the inertial data.
void RobustOdometry::measure_noise(const UpdateResult& seen, const InertialIntegral& inertial) {
  if (seen.matches < settings_.update.matches_min) return motion_noise_.interrupt();
  if (driven_scans_ < kDriven && !standstill_.calm(state_, imu_)) ++driven_scans_;
  const SE3 T_lidar = geometry::boxplus(T_predicted_, seen.lidar_shift);
  imu::MotionStep step;
  step.t = state_.t;
  step.R_odom_body = T_lidar.R;
  step.p_odom_m = T_lidar.p;
  step.known = seen.known;
  step.rotation_known = seen.rotation_known;
  step.dv_mps = inertial.dv_mps;
  step.dp_m = inertial.dp_m;
  step.dR = inertial.dR;
  motion_noise_.add(step);
  constexpr double kForget = 0.99;
  noise_boost_ = 1.0 + kForget * (noise_boost_ - 1.0);
}

/// A map that grows scan by scan turns. In odom, which the newest planes define, the vehicle and
/// gravity turn in common: no gyro notices, and the speed along a degenerate direction is the
/// integral of gravity's error. A rotation that the scan does not observe, such as roll in a round
/// pipe, is that of the inertial sensor, and turns no planes.
void RobustOdometry::turn_with_map(const UpdateResult& update) {
  const Mat3& R = state_.T_odom_body.R;
  const Mat3 observed = R * update.rotation_known * R.transpose();
  const Mat3 turned = observed * drift_.take_rotation() * observed;
  if (!inertial_) return;
  Eigen::Matrix<double, kStateDim, 3> G = Eigen::Matrix<double, kStateDim, 3>::Zero();
  G.middleRows<3>(kTheta) = R.transpose();
  G.middleRows<3>(kVel) = -geometry::skew(state_.v);
  G.middleRows<2>(kGravity) = gravity_basis(state_.g_odom_mps2).transpose();
  state_.P += G * turned * G.transpose();
}

/// The prediction with covariance for a step of the body that the inertial sensor did not measure.
/// @param where projector on the translations that may step
FilterState RobustOdometry::with_step(const FilterState& predicted, double size,
                                      const Mat3& where) const {
  constexpr double kSpeed_mps = 0.1;
  constexpr double kStep_m = 0.005;
  constexpr double kTurn_rad = 0.003;
  const double span_s = std::max(1e-3, (predicted.t - last_posterior_.t).s());
  FilterState wider = predicted;
  const double v2 = size * kSpeed_mps * kSpeed_mps;
  wider.P.block<3, 3>(kTheta, kTheta) += size * kTurn_rad * kTurn_rad * Mat3::Identity();
  wider.P.block<3, 3>(kVel, kVel) += v2 * where;
  wider.P.block<3, 3>(kPos, kVel) += 0.5 * span_s * v2 * where;
  wider.P.block<3, 3>(kVel, kPos) += 0.5 * span_s * v2 * where;
  wider.P.block<3, 3>(kPos, kPos) +=
      (span_s * span_s * v2 / 3.0 + size * kStep_m * kStep_m) * where;
  return wider;
}

/// A joint between tiles or a slipping tyre moves the body within one sample of the inertial
/// sensor, which does not measure it. If the LiDAR deviates far beyond the predicted covariance,
/// covariance for such a step is added, as large as needed; biases are not affected.
void RobustOdometry::allow_jolt(const FilterState& predicted, UpdateResult& done) {
  constexpr double kGrowth = 4.0;
  constexpr double kMax = 256.0;
  if (done.nis > settings_.update.jolt_nis && !has_many_matches(done)) {
    state_ = predicted;
    done = rejected();
    return;
  }
  for (double size = 1.0; size <= kMax && done.nis > settings_.update.jolt_nis; size *= kGrowth) {
    const Mat3 known = done.known;
    const SE3 start = state_.T_odom_body;
    state_ = with_step(predicted, size, known);
    done = update_with_scan(state_, matcher_, map_, start, settings_, axes_, closed(), true);
    if (done.known.trace() + 0.5 < known.trace()) break;
  }
  look_again(predicted, done);
  constexpr double kGain = 0.05;
  if (done.matches >= settings_.update.matches_min) usual_fit_ += kGain * (done.fit - usual_fit_);
}

/// After an impact the prediction can be so far off that the scan no longer matches its planes: it
/// is registered again from the pose at constant velocity. Over a gap in the scans no vehicle keeps
/// its velocity: the inertial data are all there is, and a scan that fits better without their turn
/// shows another corner like the last one.
void RobustOdometry::look_again(const FilterState& predicted, UpdateResult& done) {
  constexpr double kSteady_s = 0.3;
  constexpr double kPoor = 0.6;  // of the usual fit
  constexpr double kBetter = 1.1;
  constexpr double kSize = 256.0;
  const bool poor = done.fit < kPoor * usual_fit_;
  const double span_s = (predicted.t - last_posterior_.t).s();
  if (!poor || scans_in_map_ == 0 || span_s > kSteady_s) return;
  FilterState steady = with_step(predicted, kSize, Mat3::Identity());
  steady.T_odom_body = last_posterior_.T_odom_body;
  steady.T_odom_body.p += span_s * last_posterior_.v;
  steady.v = last_posterior_.v;
  FilterState other = steady;
  const UpdateResult again =
      update_with_scan(other, matcher_, map_, steady.T_odom_body, settings_, axes_, closed(), true);
  if (!has_many_matches(again) || again.fit < kBetter * done.fit) return;
  state_ = other;
  done = again;
}

/// Standstill: the pose is kept, despite the noise of the next scans, as long as the LiDAR agrees.
/// Nothing is inserted: minutes of the same view must not degrade the map.
std::optional<ScanResult> RobustOdometry::hold(const LidarScan& scan, FindingList& findings) {
  constexpr double kMoved_m = 0.03;
  constexpr double kMoved_rad = 0.006;
  FilterState trial = state_;
  const FilterState before = state_;
  const bool interrupted = is_interrupted(scan.t_end);
  if (interrupted) {
    state_.t = scan.t_end;
  } else {
    propagate_held(state_, imu_, scan.t_end, rest_noise());
  }
  const ScanMotion still(calibration_.T_body_lidar);
  still.apply(scan, sampler_.update_indices(), points_);
  matcher_.set_points(points_, calibration_.T_body_lidar.p);
  // A prior wide enough for a real motion to show.
  trial.P.topLeftCorner<6, 6>().diagonal().head<3>().array() += 1e-4;
  trial.P.topLeftCorner<6, 6>().diagonal().tail<3>().array() += 1e-2;
  const UpdateResult seen = update_with_scan(trial, matcher_, map_, trial.T_odom_body, settings_,
                                             axes_, degenerate_, true);
  const geometry::Vec6 step = geometry::boxminus(trial.T_odom_body, before.T_odom_body);
  const bool moved = seen.matches >= settings_.update.matches_min &&
                     (step.tail<3>().norm() > kMoved_m || step.head<3>().norm() > kMoved_rad);
  moved_scans_ = moved ? moved_scans_ + 1 : 0;
  // After an interruption only the LiDAR knows.
  const bool seen_here =
      seen.matches >= settings_.update.matches_min && !moved && !degenerate_axis();
  const bool stands = interrupted ? seen_here
                                  : standstill_.update(state_, imu_, degenerate_axis(),
                                                       rest_noise().gyro_radps_rthz);
  const double seen_up_m =
      -before.g_odom_mps2.normalized().dot(trial.T_odom_body.p - before.T_odom_body.p);
  const bool lifted = !interrupted && follow_lift(before, seen_up_m, findings);
  // If the inertial sensor proves standstill, apparent motion is not that of the vehicle.
  const bool starts = !stands || (moved_scans_ >= kScansToMove && !standstill_.certain());
  if (starts && !lifted) {
    end_zero_velocity(before);
    return std::nullopt;
  }
  if (lifted && !lift_.rides()) {
    // Not yet known: a start would return to before it.
    last_posterior_ = state_;
    return result_of(scan, seen);
  }
  standstill_states_.push_back(before);
  const Time keep = state_.t - Duration::from_s(standstill_.window_s());
  while (standstill_states_.size() > 1 && standstill_states_.front().t < keep)
    standstill_states_.pop_front();
  imu_.drop_before(state_.t - Duration::from_s(standstill_.memory_s()));
  t_last_good_ = state_.t;
  t_unmatched_.reset();
  last_posterior_ = state_;
  if (seen_here) cover_.show(points_, state_.T_odom_body);
  if (!lifted) return result_of(scan, seen);
  if (lift_.arrived()) arrive(scan, findings);
  return riding(scan, seen, (state_.t - before.t).s());
}

/// Motion is detected late. The filter restarts from the state at the start of the window, so that
/// the motion since then is not lost. Augmented states estimated from ranges since then are kept,
/// relative to the pose: there may be more of them now than when the window started.
void RobustOdometry::end_zero_velocity(const FilterState& before) {
  at_standstill_ = false;
  const FilterState held = state_;
  state_ = standstill_states_.empty() ? before : standstill_states_.front();
  carry_augmented_states(held, state_);
  know_bias_at_standstill();
  standstill_states_.clear();
  last_posterior_ = state_;
  moved_scans_ = 0;
  motion_noise_.interrupt();
  standstill_.reset();
}

/// Keeps the pose fixed from now on. A speed estimate at standstill came from apparent motion in
/// the LiDAR, or has no source at all.
void RobustOdometry::start_zero_velocity(FindingList& findings) {
  constexpr double kFast_mps = 0.3;
  constexpr double kSigma_mps = 0.01;
  at_standstill_ = true;
  motion_noise_.interrupt();
  acceleration_.reset();
  doubt_bias_in_bend();
  if (!standstill_.certain()) return;
  if (state_.v.norm() > kFast_mps) {
    Finding f;
    f.id = "odometry.contradiction";
    f.severity = Severity::kWarning;
    f.t = state_.t - Duration::from_s(standstill_.window_s());
    f.t_end = state_.t;
    f.text = fmt::format(
        "the inertial sensor is still while the pose moves at {:.1f} m/s: standstill is taken",
        state_.v.norm());
    f.effect = "the poses before it may be off";
    findings.push_back(f);
  }
  state_.v.setZero();
  decorrelate(state_, kVel, 3);
  state_.P.diagonal().segment<3>(kVel).setConstant(kSigma_mps * kSigma_mps);
}

void RobustOdometry::constrain(const UpdateResult& done, FindingList& findings) {
  bool known = done.matches >= settings_.update.matches_min;
  for (std::size_t k = 0; k < 3; ++k) {
    known = known && done.directions[k].category == degeneracy::Category::kFull;
  }
  const Vec3 w =
      imu_.empty() ? Vec3::Zero() : Vec3(imu_.at(state_.t).gyro_radps - state_.gyro_bias_radps);
  constraints_.update(state_, w, map_, known, done.untouched);
  bound_speed(findings);
  refuse_biases(last_posterior_.gyro_bias_radps, last_posterior_.accel_bias_mps2, findings);
}

/// Along a degenerate direction the speed is the integral of force minus gravity and bias, and its
/// error grows without bound. A vehicle's speed does not: it returns to usual values. The prior
/// bounds the error of the speed; applied more often, it would bias a constant speed towards zero.
void RobustOdometry::bound_speed(FindingList& findings) {
  constexpr double kIndependent_s = 3.0;  // a vehicle may keep its speed this long
  const auto axis = degenerate_axis();
  if (!axis) {
    // A speed observed for longer than a glimpse is usual for this vehicle.
    const bool seen = !t_seen_ || (state_.t - *t_seen_).s() > kGlimpse_s;
    if (seen) fastest_seen_mps_ = std::max(fastest_seen_mps_, state_.v.norm());
    return;
  }
  if (seconds_between(t_speed_bounded_, state_.t) < kIndependent_s) return;
  const double usual = std::max(settings_.constraints.speed_usual_mps, fastest_seen_mps_);
  const double variance = axis->dot(state_.P.block<3, 3>(kVel, kVel) * *axis);
  constexpr double kImpossible = 3.0;
  if (std::abs(axis->dot(state_.v)) > kImpossible * (usual + std::sqrt(variance))) {
    widen_speed(*axis, findings);
  } else if (variance < usual * usual) {
    return;
  }
  t_speed_bounded_ = state_.t;
  Eigen::Matrix<double, 1, kStateDim> H = Eigen::Matrix<double, 1, kStateDim>::Zero();
  H.segment<3>(kVel) = axis->transpose();
  update_linear<1>(state_, H, Eigen::Matrix<double, 1, 1>(-axis->dot(state_.v)),
                   Eigen::Matrix<double, 1, 1>(usual * usual));
}

/// A speed that is certain by the filter but impossible for such a vehicle: the inertial sensor did
/// not measure a deceleration, e.g. with slipping wheels. Both the speed and the distance since the
/// LiDAR became degenerate are then uncertain. The prior of usual speeds corrects both.
void RobustOdometry::widen_speed(const Vec3& axis_odom, FindingList& findings) {
  const double speed_mps = axis_odom.dot(state_.v);
  const double degenerate_s = seconds_between(t_degenerate_, state_.t);
  const double path_m = 0.5 * speed_mps * degenerate_s;
  const Mat3 along = axis_odom * axis_odom.transpose();
  state_.P.block<3, 3>(kVel, kVel) += speed_mps * speed_mps * along;
  state_.P.block<3, 3>(kPos, kPos) += path_m * path_m * along;
  state_.P.block<3, 3>(kPos, kVel) += path_m * speed_mps * along;
  state_.P.block<3, 3>(kVel, kPos) += path_m * speed_mps * along;
  Finding f;
  f.id = "odometry.contradiction";
  f.severity = Severity::kWarning;
  f.t = t_degenerate_;
  f.t_end = state_.t;
  f.text = fmt::format(
      "blind for {:.0f} s, by the inertial sensor alone the vehicle would drive at {:.1f} m/s, and "
      "usual are {:.1f}: the sensor has not felt all that slowed it down",
      degenerate_s, std::abs(speed_mps), settings_.constraints.speed_usual_mps);
  f.effect = fmt::format("speed and position along the path are taken back, by up to {:.0f} m",
                         std::abs(path_m));
  f.remedy = "If the vehicle is that fast, set odometry.robust.constraints.speed_usual_mps.";
  findings.push_back(f);
}

/// Adds the pose to the direction of travel, where the LiDAR measures sideways motion.
void RobustOdometry::watch_travel(FindingList& findings) {
  constexpr double kAcross = 0.5;  // cosine
  constexpr double kReported_rad = 1.0 * kRadPerDeg;
  constexpr double kReported_sigmas = 5.0;
  const Vec3 up = -state_.g_odom_mps2.normalized();
  const Vec3 up_body = state_.T_odom_body.R.transpose() * up;
  const Vec3 left = up.cross(state_.T_odom_body.R * forward_body_);
  bool measured = track_state_ == TrackState::kGood && (inertial_ || !has_imu_) && !new_map_;
  for (int k = 0; k < 3; ++k) {
    const bool open = degenerate_[static_cast<std::size_t>(k)];
    measured = measured && !(open && std::abs(left.dot(axes_.col(k))) > kAcross);
  }
  if (!measured) return travel_.interrupt();
  travel_.add(state_.T_odom_body, forward_body_, up_body);
  const auto angle = travel_.angle();
  const bool reported = angle && std::abs(angle->left_rad) >
                                     std::max(kReported_rad, kReported_sigmas * angle->sigma_rad);
  if (travel_reported_ || !reported) return;
  travel_reported_ = true;
  Finding f;
  f.id = "odometry.mounting";
  f.severity = Severity::kWarning;
  f.t = state_.t;
  f.text =
      fmt::format("the vehicle drives {:.1f} deg to the {} of the x axis of its body (+-{:.1f})",
                  std::abs(angle->left_rad) / kRadPerDeg, angle->left_rad > 0.0 ? "left" : "right",
                  angle->sigma_rad / kRadPerDeg);
  f.effect =
      "unless it crabs, the yaw of T_body_lidar is off by that: the path is turned by it against "
      "the heading of the vehicle, which start poses refer to";
  f.remedy = "Correct the yaw of lidar.T_body_lidar, or point the x axis of the body ahead.";
  f.value = angle->left_rad / kRadPerDeg;
  f.limit = kReported_rad / kRadPerDeg;
  findings.push_back(f);
}

}  // namespace rali::odometry::internal
