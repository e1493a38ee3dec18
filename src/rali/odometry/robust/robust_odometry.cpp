#include "rali/odometry/robust/robust_odometry.hpp"

#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/LU>
#include <fmt/format.h>

#include "rali/cloud/voxel_sampler.hpp"
#include "rali/odometry/mounting.hpp"
#include "rali/odometry/robust/internal/robust_filter.hpp"

namespace rali::odometry::internal {

using geometry::Mat3;
using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;
using sensor::LidarScan;

ScanResult RobustOdometry::process(const LidarScan& measured, Executor& /*executor*/,
                                   FindingList& findings) {
  const LidarScan& scan = corrected(measured);
  if (!started_) return start(scan);
  covered_ = false;
  end_refusal(scan.t_end, findings);
  if (first_scan_ && !has_imu_) deskew_first(scan);
  sampler_.sample(scan);
  if (at_standstill_ && !imu_.empty()) {
    if (auto result = hold(scan, findings)) return *result;
  }
  const bool interrupted = is_interrupted(scan.t_end);
  const bool follows = !interrupted && inertial_ && !imu_.empty() && last_posterior_.t < scan.t_end;
  const InertialIntegral inertial =
      follows ? integrate_from(last_posterior_, imu_, scan.t_end) : InertialIntegral{};
  UpdateResult done = interrupted ? resume(scan, findings) : predict_and_update(scan, inertial);
  const bool settled = has_imu_ || settle_alone(scan, predicted_, done);
  if (settled) remember_seen(done);
  watch_acceleration(settled && !interrupted);
  if (follows) {
    measure_turn_speed(inertial);
    measure_noise(done, inertial);
  } else {
    turn_speed_.interrupt();
  }
  if (inertial_) constrain(done, findings);
  if (covered_) {
    track_state_ = TrackState::kPredicted;
  } else if (settled) {
    judge(done, findings);
  }
  cover_.note(covered_, scan.t_start, scan.t_end, findings);
  watch_travel(findings);
  if (interrupted && new_map_) track_state_ = TrackState::kDiverged;
  if (!settled) stray(predicted_, findings);
  // A young map has few planes: it must grow before many matches can be required.
  const bool young = scans_in_map_ < kYoungScans;
  const bool trusted = settled && !covered_ &&
                       (track_state_ != TrackState::kPredicted || young || is_on_new_ground());
  if (trusted && map_.empty()) start_map();
  if (resumed_ && speed_is_known_again(scan.t_end)) resumed_.reset();
  if (inertial_ && trusted && !resumed_) measure_lasers(scan);
  if (trusted && !resumed_) insert(scan);
  if (has_imu_ && !inertial_) {
    remember_start(scan, done);
    try_initialise(findings);
  }
  const double gyro_noise = rest_noise().gyro_radps_rthz;
  if (inertial_ && trusted && standstill_.update(state_, imu_, degenerate_axis(), gyro_noise)) {
    start_zero_velocity(findings);
  }
  const bool rides = inertial_ && trusted && !at_standstill_ && enter_lift();
  if (inertial_) imu_.drop_before(state_.t - Duration::from_s(standstill_.memory_s()));
  map_.prune(state_.T_odom_body.p);
  last_posterior_ = state_;
  const ScanResult result = rides ? riding(scan, done, 0.0) : result_of(scan, done);
  poses_.clear();
  T_propagated_ = SE3{};
  return result;
}

UpdateResult RobustOdometry::predict_and_update(const LidarScan& scan,
                                                const InertialIntegral& inertial) {
  const SE3 T_inertial = predicted_motion(scan.t_end, inertial);
  predict(scan.t_end);
  T_last_predicted_ = inertial_ ? T_inertial : T_propagated_;
  // Without inertial data, or beyond its range, the scan is undistorted with a guess of the motion:
  // repeated with the estimated motion if it differs.
  constexpr int kRoundsOfAGuess = 3;
  predicted_ = state_;
  const bool measured =
      inertial_ && !resumed_ && !is_rotation_uncertain(predicted_.P.topLeftCorner<6, 6>());
  return update(scan, measured ? 1 : kRoundsOfAGuess);
}

/// Propagates to t_end; `poses_` contains the path since the end of the last scan.
void RobustOdometry::predict(Time t_end) {
  if (poses_.empty() || poses_.back().t != state_.t) {
    poses_.assign(1, {state_.t, state_.T_odom_body});
  }
  poses_.back().T_odom_body = state_.T_odom_body;
  if (t_end <= state_.t) return;
  if (inertial_ && !imu_.empty()) return predict_inertial(t_end);
  if (has_imu_ && !imu_.empty()) turn_with_gyro(t_end);
  ProcessNoise noise;
  noise.accel_walk = settings_.constant_velocity.accel_mps2_rthz;
  const bool measured = has_imu_ && !imu_.empty();
  noise.gyro_walk = measured ? 0.0 : settings_.constant_velocity.rate_radps2_rthz;
  const SE3 before = state_.T_odom_body;
  propagate_constant_velocity(state_, (t_end - state_.t).s(), noise);
  T_propagated_ = T_propagated_ * before.inverse() * state_.T_odom_body;
  state_.t = t_end;
  if (measured) stand_if_still();
}

void RobustOdometry::predict_inertial(Time t_end) {
  const Vec3 before_m = state_.T_odom_body.p;
  propagate_over(state_, imu_, t_end, process_noise(), poses_);
  tilt_with_map(state_, state_.T_odom_body.p - before_m, tilt_rate());
  poses_.back().T_odom_body = state_.T_odom_body;
}

/// Motion from the last scan to this one, by the estimate at that time and inertial data since;
/// shifts from ranges in between are not included.
SE3 RobustOdometry::predicted_motion(Time t_end, const InertialIntegral& inertial) const {
  const double span_s = (t_end - last_posterior_.t).s();
  const Mat3& R = last_posterior_.T_odom_body.R;
  return {inertial.dR, R.transpose() * (last_posterior_.v * span_s + inertial.dp_m)};
}

ScanMotion RobustOdometry::scan_motion(const LidarScan& scan) const {
  if (!scan.has_point_times || scan.deskewed) return ScanMotion(calibration_.T_body_lidar);
  if (inertial_) return ScanMotion(poses_, scan.t_start, calibration_.T_body_lidar);
  // Constant velocity, backwards from the end with the newest estimate of the velocity.
  constexpr int kSteps = 10;
  const double span_s = (scan.t_end - scan.t_start).s();
  std::vector<TimedPose> poses;
  for (int k = 0; k <= kSteps; ++k) {
    const double ago_s = span_s * (kSteps - k) / kSteps;
    const Vec3 turn = -ago_s * state_.gyro_bias_radps;
    SE3 T_end_then{geometry::so3_exp(turn),
                   -ago_s * (geometry::so3_right_jacobian(-turn) * state_.v)};
    poses.push_back({scan.t_end - Duration::from_s(ago_s), state_.T_odom_body * T_end_then});
  }
  return ScanMotion(poses, scan.t_start, calibration_.T_body_lidar);
}

UpdateResult RobustOdometry::update(const LidarScan& scan, int rounds) {
  const FilterState predicted = state_;
  T_predicted_ = predicted.T_odom_body;
  P_predicted_m2_ = predicted.P.block<3, 3>(kPos, kPos);
  const Vec3 p_body_lidar = calibration_.T_body_lidar.p;
  UpdateResult done;
  SE3 start = state_.T_odom_body;
  for (int k = 0; k < rounds; ++k) {
    scan_motion(scan).apply(scan, sampler_.update_indices(), points_);
    matcher_.set_points(points_, p_body_lidar);
    const Vec3 v = state_.v;
    const Vec3 w = state_.gyro_bias_radps;
    state_ = predicted;
    thin_ = false;
    done = update_with_scan(state_, matcher_, map_, start, settings_, axes_, closed(), inertial_);
    if (inertial_ && (covered_ = is_covered(predicted, done))) {
      state_ = predicted;
      return rejected();
    }
    if (inertial_) refuse_thin_hold(predicted, start, done);
    if (k == 0 && !inertial_) look_around(predicted, done);
    if (inertial_) allow_jolt(predicted, done);
    if (inertial_ && rounds > 1) bend_poses(start);
    start = state_.T_odom_body;
    const bool as_guessed =
        (state_.v - v).norm() < 0.05 && (state_.gyro_bias_radps - w).norm() < 0.01;
    if (as_guessed && !inertial_) break;
  }
  done.sees[0] = done.sees[0] && !thin_;
  return done;
}

/// The motion that a clipped gyro missed since the last scan happened throughout: the poses in
/// between get their fraction of the update's correction.
/// @param end pose before the update
void RobustOdometry::bend_poses(const SE3& end) {
  const geometry::Vec6 all = geometry::boxminus(state_.T_odom_body, end);
  const Time begin = poses_.front().t;
  const double span_s = std::max(1e-3, seconds_between(begin, state_.t));
  for (TimedPose& pose : poses_) {
    pose.T_odom_body =
        geometry::boxplus(pose.T_odom_body, seconds_between(begin, pose.t) / span_s * all);
  }
}

void RobustOdometry::insert(const LidarScan& scan) {
  scan_motion(scan).apply(scan, sampler_.insert_indices(), points_);
  insert_points(state_.T_odom_body);
  if (points_.size() > 0) ++scans_in_map_;
  if (inertial_) cover_.show(points_, state_.T_odom_body);
}

void RobustOdometry::insert_points(const SE3& T_odom_body) {
  const Mat3& R = T_odom_body.R;
  const Vec3 origin = calibration_.T_body_lidar.p;
  const double epoch = drift_.epoch();
  const SE3 T_odom_lidar = T_odom_body * calibration_.T_body_lidar;
  // With inertial data they are needed after an interruption only: a few scans along the path.
  constexpr double kSpacing_m = 0.5;
  const bool spaced =
      recent_.poses().empty() || (recent_.poses().back().p - T_odom_body.p).norm() > kSpacing_m;
  if (!has_imu_ || spaced) recent_.add(points_, T_odom_body);
  map_.set_view(T_odom_lidar);
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Vec3 p(points_.x_m[i], points_.y_m[i], points_.z_m[i]);
    const Vec3 ray = R * (p - origin);
    const double inverse = 1.0 / std::max(1e-6, ray.norm());
    map_.insert(R * p + T_odom_body.p, (inverse * ray).cast<float>(), epoch);
  }
  // With inertial data pitch and height are known until the vehicle has driven.
  if (!has_imu_ && map_.wants_scan(T_odom_lidar)) {
    std::vector<Vec3> points_odom;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Vec3 p(points_.x_m[i], points_.y_m[i], points_.z_m[i]);
      points_odom.push_back(R * p + T_odom_body.p);
    }
    map_.set_scan(ViewPlanes(points_odom, T_odom_lidar, epoch, settings_.map.plane));
  }
}

/// Roll and pitch at which the accelerometer would measure its values: by gravity's direction in
/// odom and the accelerometer's bias.
std::optional<Level> RobustOdometry::level() const {
  if (!inertial_) return std::nullopt;
  const Vec3& g = state_.g_odom_mps2;
  const Eigen::Matrix<double, 3, 2> axes = gravity_basis(g);
  Eigen::Matrix<double, 2, kStateDim> H = Eigen::Matrix<double, 2, kStateDim>::Zero();
  H.block<2, 3>(0, kAccelBias) =
      -axes.transpose() * geometry::skew(g) * state_.T_odom_body.R / g.squaredNorm();
  H.block<2, 2>(0, kGravity).setIdentity();
  return Level{axes, H * state_.P * H.transpose(), map_tilt_rad(state_)};
}

/// The filter's covariance for this scan, once more the covariance of one registration (the filter
/// treats repeated views of the same planes as independent), and the error of the map there.
Mat6 RobustOdometry::covariance(const UpdateResult& update) {
  Mat6 local = state_.P.topLeftCorner<6, 6>();
  if (update.matches < settings_.update.matches_min) {
    return drift_.update(state_.T_odom_body, update.mean_epoch, local, update.following, level(),
                         {}, bend_.turned_covariance(state_));
  }
  const double weak = 1.0 / (settings_.drift.sigma_max_m * settings_.drift.sigma_max_m);
  const Mat6 single = (update.information + weak * Mat6::Identity()).inverse();
  local += update.following.follows * single * update.following.follows.transpose();
  std::vector<HeldAlong> held;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3& d_odom = update.directions[k].direction_odom;
    if (const auto epoch = matcher_.mean_epoch(d_odom)) held.push_back({d_odom, *epoch});
  }
  return drift_.update(state_.T_odom_body, update.mean_epoch, local, update.following, level(),
                       held, bend_.turned_covariance(state_));
}

/// Along degenerate directions the map's error becomes part of the filter's covariance.
void RobustOdometry::release(const UpdateResult& update) {
  if (update.untouched.isZero(0.0)) return;
  const Mat3 released = drift_.release(state_.T_odom_body, update.untouched);
  state_.P.block<3, 3>(kPos, kPos) += released;
  // The end of a standstill returns to one of these.
  for (FilterState& earlier : standstill_states_) earlier.P.block<3, 3>(kPos, kPos) += released;
}

/// The motion since the last scan by the LiDAR; shifts from ranges are not included.
void RobustOdometry::watch_acceleration(bool settled) {
  if (!settled) return acceleration_.reset();
  SE3 step = T_last_predicted_ * (T_predicted_.inverse() * state_.T_odom_body);
  const Vec3 shift = state_.T_odom_body.p - T_predicted_.p;
  const Mat3& R = T_predicted_.R;
  step.p = T_last_predicted_.p +
           T_last_predicted_.R * R.transpose() * unexplained_shift(shift, P_predicted_m2_);
  acceleration_.add(state_.t, step);
}

/// Why no such vehicle can have moved as the pose did; empty if it can.
std::string RobustOdometry::impossible_motion() const {
  const ConstraintSettings& limits = settings_.constraints;
  if (!state_.T_odom_body.p.allFinite() || !state_.T_odom_body.R.allFinite() ||
      !state_.v.allFinite()) {
    return "the pose is not a number";
  }
  if (state_.v.norm() > limits.speed_max_mps) {
    return fmt::format("the pose moves at {:.0f} m/s, and {:.0f} are possible", state_.v.norm(),
                       limits.speed_max_mps);
  }
  const double accel_mps2 = acceleration_.mean_mps2().value_or(0.0);
  if (accel_mps2 <= limits.accel_max_mps2) return {};
  return fmt::format("over a second the pose accelerates by {:.0f} m/s2, and {:.0f} are possible",
                     accel_mps2, limits.accel_max_mps2);
}

/// Good, weak (few matches), predicted (none), or diverged (for too long, or impossible).
void RobustOdometry::judge(const UpdateResult& update, FindingList& findings) {
  constexpr double kLost_s = 2.0;
  const std::string impossible = impossible_motion();
  if (impossible.empty() && update.matches >= settings_.update.matches_min) {
    track_state_ = has_many_matches(update) ? TrackState::kGood : TrackState::kWeak;
    t_last_good_ = state_.t;
    t_unmatched_.reset();
    return;
  }
  track_state_ = TrackState::kPredicted;
  // With inertial data from the first such scan: while scans are missing, none contradicts the map.
  if (!t_unmatched_) t_unmatched_ = state_.t;
  const Time since = inertial_ ? *t_unmatched_ : t_last_good_;
  if (impossible.empty() && seconds_between(since, state_.t) < kLost_s) return;
  track_state_ = TrackState::kDiverged;
  restart(impossible, findings);
}

ScanResult RobustOdometry::result_of(const LidarScan& scan, const UpdateResult& update) {
  ScanResult out;
  out.t = scan.t_end;
  out.state = track_state_;
  out.at_rest = at_standstill_;
  out.inertial = inertial_;
  if (inertial_) {
    const ProcessNoise noise = process_noise();
    out.inertial_noise = {noise.gyro_radps_rthz, noise.accel_mps2_rthz};
    if (!at_standstill_) out.measured_noise = motion_noise_.measured();
    out.gyro_bias_radps = state_.gyro_bias_radps;
    out.accel_bias_mps2 = state_.accel_bias_mps2;
    out.force_sigma_mps2 = odometry::force_sigma_mps2(state_);
  }
  out.T_odom_body = quiet_start_ && !inertial_ ? track_.front().T_odom_body : state_.T_odom_body;
  out.T_odom_body_predicted = at_standstill_ ? out.T_odom_body : T_predicted_;
  if (!at_standstill_) out.T_last_predicted = T_last_predicted_;
  // Until gravity is known the start may be at standstill, and the scan that initialises it replays
  // the start: the resulting shift is a correction, not motion.
  if (has_imu_ && (!inertial_ || !reported_inertial_)) {
    if (quiet_start_ && !inertial_) out.T_last_predicted = SE3{};
    out.T_odom_body_predicted = T_reported_ * out.T_last_predicted;
  }
  out.new_map = new_map_;
  new_map_ = false;
  T_reported_ = out.T_odom_body;
  reported_inertial_ = inertial_;
  out.v_odom_mps = inertial_ ? state_.v : Vec3(state_.T_odom_body.R * state_.v);
  if (!T_odom_first_) T_odom_first_ = out.T_odom_body;
  constexpr double kDegree = std::numbers::pi / 180.0;
  out.covariance = covariance(update) + mounting_covariance(*T_odom_first_, out.T_odom_body,
                                                            kDegree * settings_.mounting_sigma_deg);
  release(update);
  turn_with_map(update);
  out.lidar_information = bend_.unseen_in(update.information, state_);
  out.planes = matcher_.evidence();
  if (update.matches > 0) out.directions = update.directions;
  out.matches = update.matches;
  out.iterations = update.iterations;
  out.residual_rms_m = update.residual_rms_m;
  if (track_state_ == TrackState::kGood || track_state_ == TrackState::kWeak) {
    last_good_ = state_.T_odom_body;
    if (!at_standstill_ && keyframer_.wants(out.T_odom_body)) {
      scan_motion(scan).apply(scan, {}, points_);
      out.keyframe = keyframer_.make(scan, points_, out, calibration_.T_body_lidar);
    }
  }
  return out;
}

std::uint64_t RobustOdometry::state_hash() const {
  std::uint64_t h = map_.hash();
  const auto mix = [&h](double v) { h = cloud::hash_key(h ^ std::bit_cast<std::uint64_t>(v)); };
  for (int k = 0; k < 9; ++k) mix(state_.T_odom_body.R.data()[k]);
  for (int k = 0; k < 3; ++k) {
    mix(state_.T_odom_body.p[k]);
    mix(state_.v[k]);
    mix(state_.gyro_bias_radps[k]);
    mix(state_.accel_bias_mps2[k]);
  }
  for (int k = 0; k < kStateDim * kStateDim; ++k) mix(state_.P.data()[k]);
  return h;
}

}  // namespace rali::odometry::internal

namespace rali::odometry {

std::unique_ptr<Odometry> make_robust_odometry(const OdometrySettings& settings,
                                               const sensor::Calibration& calibration, bool has_imu,
                                               const geometry::Vec3& forward_body) {
  OdometrySettings own = settings;
  own.robust.aware.lidar_alone = !has_imu;
  return std::make_unique<internal::RobustOdometry>(own, calibration, has_imu, forward_body);
}

}  // namespace rali::odometry
