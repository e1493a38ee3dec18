#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <fmt/format.h>

#include "rali/odometry/robust/internal/robust_filter.hpp"
#include "rali/odometry/robust/range_noise.hpp"
#include "rali/odometry/robust/range_picture.hpp"

namespace rali::odometry::internal {

using geometry::Mat3;
using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;
using sensor::LidarScan;

/// The first scan defines odom: its own origin and heading; up is against the mean force.
ScanResult RobustOdometry::start(const LidarScan& scan) {
  if (scan.size() == 0) return {};
  started_ = true;
  set_range_noise(scan);
  if (!scan.has_point_times && !scan.deskewed) {
    PlaneSettings& plane = settings_.map.plane;
    plane.excess_max_m = std::max(plane.excess_max_m, plane.excess_max_bent_m);
  }
  map_ = PlaneMap(settings_.map);
  state_.t = scan.t_end;
  state_.g_odom_mps2 = Vec3(0.0, 0.0, -settings_.initialisation.gravity_mps2);
  if (has_imu_ && !imu_.empty()) {
    const Vec3 force =
        imu::statistics(imu_.between(Time{std::numeric_limits<std::int64_t>::min()}, scan.t_end))
            .accel_mean_mps2;
    if (force.norm() > 1.0) state_.T_odom_body.R = imu::level(force);
  }
  const ConstantVelocitySettings& cv = settings_.constant_velocity;
  state_.P.setZero();
  state_.P.diagonal().segment<3>(kTheta).setConstant(1e-10);
  state_.P.diagonal().segment<3>(kPos).setConstant(1e-10);
  state_.P.diagonal().segment<3>(kVel).setConstant(cv.start_speed_mps * cv.start_speed_mps);
  state_.P.diagonal().segment<3>(kGyroBias).setConstant(cv.start_rate_radps * cv.start_rate_radps);
  poses_.assign(1, {state_.t, state_.T_odom_body});  // the path before is unknown
  if (const auto rate = gyro_rate(scan.t_start, scan.t_end)) state_.gyro_bias_radps = *rate;
  sampler_.sample(scan);
  insert(scan);
  start_view(scan);
  if (scan.has_point_times && !scan.deskewed) first_scan_ = std::make_unique<LidarScan>(scan);
  if (has_imu_) start_scans_.push_back(scan);
  track_state_ = TrackState::kGood;
  t_last_good_ = state_.t;
  track_.push_back({state_.t, state_.T_odom_body, Mat3::Zero()});
  UpdateResult none;
  none.converged = true;
  return result_of(scan, none);
}

/// With the noise of a good sensor, the map of a noisy one would contain no planes. A less noisy
/// sensor gains nothing: poses and surfaces spread a cell's points by as much.
void RobustOdometry::set_range_noise(const LidarScan& scan) {
  constexpr double kMin_m = 0.02;
  constexpr double kMax_m = 0.1;
  const double given_m = settings_.range_sigma_m;
  const double sigma_m =
      given_m > 0.0 ? given_m
                    : std::clamp(measure_range_noise(scan).value_or(kMin_m), kMin_m, kMax_m);
  settings_.map.plane.range_sigma_m = sigma_m;
  matcher_.set_range_sigma(sigma_m);
}

/// The turn rate during a scan from the gyro, if there is one that did not clip.
std::optional<Vec3> RobustOdometry::gyro_rate(Time begin, Time end) const {
  if (!has_imu_ || imu_.empty() || imu_.clipped(begin, end).any()) return std::nullopt;
  const std::vector<sensor::ImuSample> samples = imu_.between(begin, end);
  if (samples.empty()) return std::nullopt;
  return imu::statistics(samples).gyro_mean_radps;
}

/// The first scan was undistorted with unknown speed, and the whole map depends on it. Once the
/// second scan gives the speed, the map is rebuilt with it, until both agree.
void RobustOdometry::deskew_first(const LidarScan& second) {
  constexpr int kRounds = 3;
  const std::unique_ptr<LidarScan> first = std::move(first_scan_);
  const FilterState begin = state_;
  const SE3 propagated = T_propagated_;
  Vec3 v = Vec3::Zero();
  Vec3 w = Vec3::Zero();
  for (int k = 0; k < kRounds; ++k) {
    poses_.clear();
    predict(second.t_end);
    sampler_.sample(second);
    // Both scans are undistorted alike, so that the effect of a wrong speed cancels.
    const UpdateResult done = update(second, 1);
    const bool useful = done.matches >= settings_.update.matches_min;
    if (useful) {
      v = state_.v;
      w = state_.gyro_bias_radps;
    }
    state_ = begin;
    state_.v = v;
    state_.gyro_bias_radps = w;
    map_ = PlaneMap(settings_.map);
    recent_.clear();
    sampler_.sample(*first);
    insert(*first);
    if (!useful) break;
  }
  poses_.clear();
  T_propagated_ = propagated;
}

/// Before gravity is known the gyro already gives the turn rate, up to its turn-on bias: sparse
/// rings constrain pitch and height poorly in their first scans.
void RobustOdometry::turn_with_gyro(Time t_end) {
  const std::optional<Vec3> rate = gyro_rate(state_.t, t_end);
  if (!rate) return;
  const double bias = 0.4 * settings_.initialisation.rest.gyro_mean_max_radps;
  state_.gyro_bias_radps = *rate;
  decorrelate(state_, kGyroBias, 3);
  state_.P.diagonal().segment<3>(kGyroBias).setConstant(bias * bias);
}

/// Without inertial data the prediction can be too poor for the registration to converge to the
/// right pose: other poses near the prediction are tried, and the best fit is kept.
void RobustOdometry::look_around(const FilterState& predicted, UpdateResult& done) {
  if (has_imu_) return;
  const Vec3 up = -state_.g_odom_mps2.normalized();
  std::vector<Vec3> unseen;
  for (int k = 0; k < 3; ++k) {
    if (degenerate_[static_cast<std::size_t>(k)]) unseen.emplace_back(axes_.col(k));
  }
  const PoseGuess guess =
      guess_from(predicted.T_odom_body, predicted.P.topLeftCorner<6, 6>(), unseen, up);
  if (!needs_search(guess, settings_.search)) return;
  for (const SE3& start : search_pose(recent_, points_, guess, up, settings_.search)) {
    FilterState other = predicted;
    const UpdateResult elsewhere =
        update_with_scan(other, matcher_, map_, start, settings_, axes_, degenerate_, false);
    if (elsewhere.fit > 1.05 * done.fit) {
      done = elsewhere;
      state_ = other;
    }
  }
}

/// Before gravity is known the LiDAR's poses drift along degenerate directions, and a young map
/// constrains little. If the inertial data show no shaking, the speed is set to zero along these.
/// Along observable directions it is not: slow driving over a smooth floor looks the same.
void RobustOdometry::stand_if_still() {
  if (start_moved_) return;
  const InitialisationSettings& init = settings_.initialisation;
  const std::vector<sensor::ImuSample> samples = imu_.between(track_.front().t, state_.t);
  const imu::ImuStatistics raw = imu::statistics(samples);
  const bool still = raw.samples > 0 &&
                     is_quiet(imu::statistics(block_means(samples)), init.rest) &&
                     (raw.accel_sd_mps2.array() < init.still_accel_sd_max_mps2).all() &&
                     raw.gyro_mean_radps.norm() < init.rest.gyro_mean_max_radps;
  if (!still) return;
  const Mat3& R = state_.T_odom_body.R;
  const Mat3 unseen = R.transpose() * (Mat3::Identity() - lidar_known_) * R;  // v is in the body
  Eigen::Matrix<double, 3, kStateDim> H = Eigen::Matrix<double, 3, kStateDim>::Zero();
  H.block<3, 3>(0, kVel) = unseen;
  const Vec3 residual = -unseen * state_.v;
  const double sigma = init.still_speed_sigma_mps;
  update_linear<3>(state_, H, residual, sigma * sigma * Mat3::Identity());
}

/// Keeps the scan as it is without motion, in case the vehicle turns out to be at standstill: the
/// speed guessed by the LiDAR alone in its first scans would distort it.
void RobustOdometry::remember_start(const LidarScan& scan, const UpdateResult& seen) {
  constexpr std::size_t kScansMax = 30;
  constexpr std::size_t kReplayMax = 60;  // a longer start is not replayed
  if (start_scans_.size() < kReplayMax && !start_scans_.empty()) {
    start_scans_.push_back(scan);
  } else {
    start_scans_.clear();
  }
  if (start_points_.size() < kScansMax) {
    const ScanMotion still(calibration_.T_body_lidar);
    still.apply(scan, sampler_.insert_indices(), start_points_.emplace_back());
  }
  const Time begin = track_.front().t;
  const imu::ImuStatistics blocks = imu::statistics(block_means(imu_.between(begin, state_.t)));
  // A young map and passers-by drag the first poses by several sigma of one registration,
  // decimetres along a corridor.
  constexpr double kDragged_sigmas2 = 100.0;
  Mat6 I = seen.information;
  I.diagonal().array() += 1.0 / (settings_.drift.sigma_max_m * settings_.drift.sigma_max_m);
  const Mat6 single = I.inverse();
  const Mat6 P = state_.P.topLeftCorner<6, 6>() + kDragged_sigmas2 * single;
  const SE3& first = track_.front().T_odom_body;
  // The inertial data of a slowly turning vehicle are as quiet as those of one at standstill.
  const Vec3 up_body = -state_.T_odom_body.R.transpose() * state_.g_odom_mps2.normalized();
  const double turn_rad =
      up_body.dot(geometry::so3_log(first.R.transpose() * state_.T_odom_body.R));
  start_moved_ = has_travelled(state_.T_odom_body.p - first.p, P.bottomRightCorner<3, 3>(),
                               settings_.initialisation.rest_travel_max_m) ||
                 has_turned(turn_rad, up_body.dot(P.topLeftCorner<3, 3>() * up_body));
  quiet_start_ = !start_moved_ && is_quiet(blocks, settings_.initialisation.rest);
}

/// All scans so far were taken from the first pose.
void RobustOdometry::start_again_at_rest() {
  // The map of the first scan alone was poor, and the poses estimated in it drift: all of them are
  // set to the first one. Gravity was computed at the last of them: it is kept in the body frame.
  const Mat3 back = track_.front().T_odom_body.R * state_.T_odom_body.R.transpose();
  state_.g_odom_mps2 = back * state_.g_odom_mps2;
  state_.g_first_odom_mps2 = state_.g_odom_mps2;
  state_.T_odom_body = track_.front().T_odom_body;
  decorrelate(state_, kTheta, 6);
  // Motion is detected late: a starting vehicle counts as at standstill until it has moved a
  // centimetre.
  constexpr double kUnnoticed_m = 0.01;
  state_.P.topLeftCorner<6, 6>() = 1e-10 * Mat6::Identity();
  state_.P.diagonal().segment<3>(kPos).setConstant(kUnnoticed_m * kUnnoticed_m);
  drift_ = track_drift_;
  map_ = PlaneMap(settings_.map);
  recent_.clear();
  for (const BodyPoints& points : start_points_) {
    points_ = points;
    insert_points(state_.T_odom_body);
  }
}

/// Once gravity, velocity and biases can be solved for, the filter switches to inertial data.
void RobustOdometry::try_initialise(FindingList& findings) {
  // Where the LiDAR is degenerate the pose relies on the assumption of no motion. That helps the
  // registration, but gravity and speed must be solved without it.
  constexpr double kUnseen_m = 100.0;
  const Mat3 unseen = Mat3::Identity() - lidar_known_;
  track_.push_back({state_.t, state_.T_odom_body,
                    state_.P.block<3, 3>(kPos, kPos) + kUnseen_m * kUnseen_m * unseen});
  // Whether an engine idles is known after some time only.
  const bool long_enough = seconds_between(track_.front().t, state_.t) >= kIdling_s;
  const bool same_view = quiet_start_ && long_enough && start_scans_.size() > 2 &&
                         !view_has_changed(start_scans_[0], start_scans_[1], start_scans_.back());
  const auto guess = solve_initial(track_, imu_, settings_.initialisation, noise_, same_view,
                                   settings_.constraints.speed_usual_mps);
  const bool may_stand = quiet_start_ && !long_enough;
  if (guess && (guess->at_rest || (guess->gravity_known && !may_stand))) {
    start_inertial(*guess);
    if (guess->at_rest && quiet_start_) {
      start_again_at_rest();
      standstill_.stood_since(track_.front().t, state_.T_odom_body);
    } else {
      replay_start(*guess, findings);
    }
    end_start(guess->at_rest, findings);
    return;
  }
  if (guess && start_early(*guess, findings)) return end_start(false, findings);
  const Time oldest = state_.t - Duration::from_s(settings_.initialisation.give_up_s + 1.0);
  std::erase_if(track_, [oldest](const TrackedPose& p) { return p.t < oldest; });
  imu_.drop_before(oldest);
}

/// From here on the filter runs on inertial data.
void RobustOdometry::start_inertial(const InitialGuess& guess) {
  inertial_ = true;
  state_.v = guess.v_odom_mps;
  state_.gyro_bias_radps = guess.gyro_bias_radps;
  state_.accel_bias_mps2 = guess.accel_bias_mps2;
  state_.g_odom_mps2 = guess.g_odom_mps2;
  decorrelate(state_, kVel, kStateDim - kVel);
  const double gyro_var = guess.gyro_bias_sigma_radps * guess.gyro_bias_sigma_radps;
  state_.P.block<3, 3>(kVel, kVel) = guess.velocity_covariance;
  state_.P.diagonal().segment<3>(kGyroBias).setConstant(gyro_var);
  state_.P.block<5, 5>(kAccelBias, kAccelBias) = guess.bias_gravity_covariance;
  begin_tilt(state_, tilt_rate());
  if (guess.at_rest) standstill_.learn(imu::statistics(imu_.between(track_.front().t, state_.t)));
}

void RobustOdometry::end_start(bool at_rest, FindingList& findings) {
  start_points_.clear();
  start_scans_.clear();
  track_.clear();
  next_search_s_ = 0.0;
  Finding f;
  f.id = at_rest ? "odometry.start_at_rest" : "odometry.start_in_motion";
  f.severity = Severity::kInfo;
  f.t = state_.t;
  f.text = at_rest ? "gravity and gyro bias estimated at standstill"
                   : "gravity, speed and gyro bias estimated while moving";
  findings.push_back(f);
}

/// The first scan in an empty map defines the map's frame: the filter's pose becomes exact, and its
/// covariance becomes an error of the whole map.
void RobustOdometry::start_map() {
  new_map_ = true;
  drift_.add(state_.T_odom_body, state_.P.topLeftCorner<6, 6>());
  decorrelate(state_, kTheta, 6);
  state_.P.diagonal().head<6>().setConstant(1e-10);
}

/// The map no longer matches the scans: a new map starts at the last plausible pose.
/// @param impossible motion that no such vehicle makes; empty if the LiDAR is lost
void RobustOdometry::restart(const std::string& impossible, FindingList& findings) {
  Finding f;
  f.id = "odometry.diverged";
  f.severity = Severity::kError;
  f.t = t_last_good_;
  f.t_end = state_.t;
  const std::string why = impossible.empty() ? "the LiDAR fits the map nowhere" : impossible;
  f.text = fmt::format("lost for {:.1f} s: {}", (state_.t - t_last_good_).s(), why);
  f.effect = "this stretch is cut from the map; poses after it hang on a guess";
  findings.push_back(f);
  start_anew();
}

/// A new map, at the last plausible pose; gravity and speed are to be solved for again.
void RobustOdometry::start_anew() {
  const Time now = state_.t;
  const SE3 pose = last_good_;
  const Vec3 gravity = state_.g_odom_mps2;
  AugmentedStates augmented = std::move(state_.augmented);
  state_ = FilterState{};
  state_.P_augmented = AugmentedCross::Zero(kStateDim, augmented.size());
  state_.augmented = std::move(augmented);
  state_.t = now;
  state_.T_odom_body = pose;
  state_.g_odom_mps2 = gravity.allFinite() ? gravity : FilterState{}.g_odom_mps2;
  state_.g_first_odom_mps2 = state_.g_odom_mps2;
  const ConstantVelocitySettings& cv = settings_.constant_velocity;
  state_.P.diagonal().segment<3>(kTheta).setConstant(0.01);
  state_.P.diagonal().segment<3>(kPos).setConstant(1.0);
  state_.P.diagonal().segment<3>(kVel).setConstant(cv.start_speed_mps * cv.start_speed_mps);
  state_.P.diagonal().segment<3>(kGyroBias).setConstant(cv.start_rate_radps * cv.start_rate_radps);
  inertial_ = false;
  track_.assign(1, {now, pose, Mat3::Zero()});
  track_drift_ = drift_;
  start_points_.clear();
  start_scans_.clear();
  start_moved_ = false;
  map_ = PlaneMap(settings_.map);
  recent_.clear();
  scans_in_map_ = 0;
  acceleration_.reset();
  new_map_ = true;
  resumed_.reset();
  t_last_good_ = now;
  t_unmatched_.reset();
}

}  // namespace rali::odometry::internal
