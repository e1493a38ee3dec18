#include "rali/odometry/robust/robust_odometry.hpp"

#include <Eigen/LU>
#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <deque>
#include <limits>

#include "rali/cloud/voxel_sampler.hpp"
#include "rali/odometry/robust/inertial.hpp"
#include "rali/odometry/robust/initialiser.hpp"
#include "rali/odometry/robust/block_means.hpp"
#include "rali/odometry/robust/drift.hpp"
#include "rali/odometry/robust/keyframer.hpp"
#include "rali/odometry/robust/scan_sampler.hpp"
#include "rali/odometry/robust/standstill.hpp"
#include "rali/odometry/robust/update.hpp"
#include "rali/odometry/robust/vehicle_constraints.hpp"

namespace rali::odometry {

using geometry::Mat3;
using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;
using sensor::LidarScan;

namespace {

class RobustOdometry final : public Odometry {
 public:
  RobustOdometry(const OdometrySettings& settings, const sensor::Calibration& calibration,
                 bool has_imu)
      : settings_(settings.robust),
        noise_(settings.imu_noise),
        calibration_(calibration),
        has_imu_(has_imu),
        sampler_(settings.robust.sampling),
        matcher_(settings.robust.match),
        map_(settings.robust.map),
        keyframer_(settings.robust.keyframe),
        drift_(settings.robust.drift),
        standstill_(settings.robust.constraints, settings.robust.initialisation.rest,
                    settings.imu_noise),
        constraints_(settings.robust.constraints) {}

  void add_imu(const sensor::ImuSample& sample) override { imu_.add(sample); }

  ScanResult process(const LidarScan& scan, Executor& executor, FindingList& findings) override;

  [[nodiscard]] Vec3 gravity_odom() const override { return state_.g_odom_mps2; }

  [[nodiscard]] Mat3 gravity_covariance() const override {
    const Eigen::Matrix<double, 3, 2> J =
        -geometry::skew(state_.g_odom_mps2) * gravity_basis(state_.g_odom_mps2);
    return J * state_.P.block<2, 2>(kGravity, kGravity) * J.transpose();
  }

  [[nodiscard]] std::uint64_t state_hash() const override;

 private:
  ScanResult start(const LidarScan& scan);
  void straighten_first(const LidarScan& second);
  void predict(Time t_end);
  void turn_with_gyro(Time t_end);
  [[nodiscard]] SweepMotion sweep_motion(const LidarScan& scan) const;
  UpdateResult update(const LidarScan& scan, int rounds);
  void look_around(const FilterState& predicted, UpdateResult& done);
  void remember_start(const LidarScan& scan);
  void try_initialise(FindingList& findings);
  void insert(const LidarScan& scan);
  void insert_points(const SE3& T_odom_body);
  std::optional<ScanResult> hold(const LidarScan& scan);
  void constrain(const UpdateResult& done, FindingList& findings);
  [[nodiscard]] Mat6 covariance(const UpdateResult& update);
  void bound_biases(FindingList& findings);
  void judge(const UpdateResult& update, FindingList& findings);
  void restart(FindingList& findings);
  void begin_map();
  ScanResult result_of(const LidarScan& scan, const UpdateResult& update);

  RobustSettings settings_;
  ImuNoiseSettings noise_;
  sensor::Calibration calibration_;
  bool has_imu_;
  bool inertial_ = false;  ///< gravity is known, the filter runs on inertial data
  bool started_ = false;

  FilterState state_;
  InertialBuffer imu_;
  std::vector<TimedPose> poses_;  ///< of the last prediction
  std::vector<TrackedPose> track_;  ///< until gravity is known
  ScanSampler sampler_;
  Matcher matcher_;
  PlaneMap map_;
  RecentPoints recent_;  ///< without inertial data only
  std::unique_ptr<LidarScan> first_scan_;  ///< until the second tells how fast it was taken
  Keyframer keyframer_;
  Drift drift_;
  StandstillDetector standstill_;
  VehicleConstraints constraints_;
  bool held_ = false;  ///< the vehicle stands
  bool quiet_start_ = false;  ///< nothing has shown motion since the first scan
  std::deque<FilterState> held_states_;  ///< of the last moments of holding
  std::vector<BodyPoints> start_points_;  ///< of the first scans, until gravity is known
  BodyPoints points_;
  degeneracy::Axes axes_ = degeneracy::Axes::Identity();
  TrackState track_state_ = TrackState::kWaiting;
  static constexpr int kYoungScans = 5;
  int scans_in_map_ = 0;
  Time t_last_good_;
  SE3 last_good_;
  bool bias_reported_ = false;
};

ScanResult RobustOdometry::process(const LidarScan& scan, Executor& /*executor*/,
                                   FindingList& findings) {
  if (!started_) return start(scan);
  if (first_scan_ && !has_imu_) straighten_first(scan);
  sampler_.sample(scan);
  if (held_ && !imu_.empty()) {
    if (auto result = hold(scan)) return *result;
  }
  predict(scan.t_end);
  // Without inertial data the sweep is undistorted with a guessed velocity: again with the
  // velocity that came out, if it is another one.
  constexpr int kRoundsWithoutImu = 3;
  const UpdateResult done = update(scan, inertial_ ? 1 : kRoundsWithoutImu);
  if (inertial_) constrain(done, findings);
  judge(done, findings);
  // A young map has few planes: it must grow before it can be asked for many.
  const bool young = scans_in_map_ < kYoungScans;
  const bool trusted = track_state_ != TrackState::kPredicted || young;
  if (trusted && map_.empty()) begin_map();
  if (trusted) insert(scan);
  if (has_imu_ && !inertial_) {
    remember_start(scan);
    try_initialise(findings);
  }
  held_ = inertial_ && trusted && standstill_.update(state_, imu_);
  if (inertial_) imu_.drop_before(state_.t - Duration::from_s(2.0 * standstill_.window_s()));
  map_.prune(state_.T_odom_body.p);
  return result_of(scan, done);
}

/// Standing still: the pose stays as it is, whatever the noise of the next scans, as long as the
/// LiDAR agrees. Nothing is inserted: minutes of the same view must not wear the map out.
std::optional<ScanResult> RobustOdometry::hold(const LidarScan& scan) {
  constexpr double kMoved_m = 0.03;
  constexpr double kMoved_rad = 0.006;
  FilterState trial = state_;
  const FilterState before = state_;
  propagate_held(state_, imu_, scan.t_end, noise_);
  const SweepMotion still(calibration_.T_body_lidar);
  still.apply(scan, sampler_.update_indices(), points_);
  matcher_.set_points(points_, calibration_.T_body_lidar.p);
  // A prior wide enough to show motion, should there be some.
  trial.P.topLeftCorner<6, 6>().diagonal().head<3>().array() += 1e-4;
  trial.P.topLeftCorner<6, 6>().diagonal().tail<3>().array() += 1e-2;
  const UpdateResult seen = update_with_scan(trial, matcher_, map_, trial.T_odom_body, settings_,
                                             axes_, false);
  const geometry::Vec6 step = geometry::boxminus(trial.T_odom_body, before.T_odom_body);
  const bool moved = seen.matches >= settings_.update.matches_min &&
                     (step.tail<3>().norm() > kMoved_m || step.head<3>().norm() > kMoved_rad);
  if (moved || !standstill_.update(state_, imu_)) {
    // Motion shows late: what the pose missed since the window began is made up for.
    held_ = false;
    state_ = held_states_.empty() ? before : held_states_.front();
    held_states_.clear();
    standstill_.reset();
    return std::nullopt;
  }
  held_states_.push_back(before);
  const Time keep = state_.t - Duration::from_s(standstill_.window_s());
  while (held_states_.front().t < keep) held_states_.pop_front();
  imu_.drop_before(state_.t - Duration::from_s(2.0 * standstill_.window_s()));
  t_last_good_ = state_.t;
  return result_of(scan, seen);
}

void RobustOdometry::constrain(const UpdateResult& done, FindingList& findings) {
  bool known = done.matches >= settings_.update.matches_min;
  for (std::size_t k = 0; k < 3; ++k) {
    known = known && done.directions[k].category == degeneracy::Category::kFull;
  }
  const Vec3 w = imu_.empty() ? Vec3::Zero()
                              : Vec3(imu_.at(state_.t).gyro_radps - state_.gyro_bias_radps);
  constraints_.update(state_, w, map_, known);
  bound_biases(findings);
}

/// The first scan defines odom: origin and heading are its own, up is against the mean force.
ScanResult RobustOdometry::start(const LidarScan& scan) {
  if (scan.size() == 0) return {};
  started_ = true;
  state_.t = scan.t_end;
  state_.g_odom_mps2 = Vec3(0.0, 0.0, -settings_.initialisation.gravity_mps2);
  if (has_imu_ && !imu_.empty()) {
    const Vec3 force = imu::statistics(imu_.between(Time{std::numeric_limits<std::int64_t>::min()}, scan.t_end)).accel_mean_mps2;
    if (force.norm() > 1.0) state_.T_odom_body.R = imu::level(force);
  }
  const ConstantVelocitySettings& cv = settings_.constant_velocity;
  state_.P.setZero();
  state_.P.diagonal().segment<3>(kTheta).setConstant(1e-10);
  state_.P.diagonal().segment<3>(kPos).setConstant(1e-10);
  state_.P.diagonal().segment<3>(kVel).setConstant(cv.start_speed_mps * cv.start_speed_mps);
  state_.P.diagonal().segment<3>(kGyroBias).setConstant(cv.start_rate_radps * cv.start_rate_radps);
  poses_.assign(1, {state_.t, state_.T_odom_body});
  sampler_.sample(scan);
  insert(scan);
  if (scan.has_point_times && !scan.deskewed) first_scan_ = std::make_unique<LidarScan>(scan);
  track_state_ = TrackState::kGood;
  t_last_good_ = state_.t;
  track_.push_back({state_.t, state_.T_odom_body, 0.0});
  UpdateResult none;
  none.converged = true;
  return result_of(scan, none);
}

/// The first scan was undistorted without knowing the speed, and everything hangs on it. Once
/// the second tells the speed, the map is begun again with it, until both agree.
void RobustOdometry::straighten_first(const LidarScan& second) {
  constexpr int kRounds = 3;
  const std::unique_ptr<LidarScan> first = std::move(first_scan_);
  const FilterState begin = state_;
  Vec3 v = Vec3::Zero();
  Vec3 w = Vec3::Zero();
  for (int k = 0; k < kRounds; ++k) {
    predict(second.t_end);
    sampler_.sample(second);
    // Both sweeps are undistorted alike: what a wrong speed does to them then cancels.
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
}

void RobustOdometry::predict(Time t_end) {
  poses_.assign(1, {state_.t, state_.T_odom_body});
  if (inertial_ && !imu_.empty()) {
    propagate_over(state_, imu_, t_end, noise_, poses_);
    return;
  }
  if (has_imu_ && !imu_.empty()) turn_with_gyro(t_end);
  ProcessNoise noise;
  noise.accel_walk = settings_.constant_velocity.accel_mps2_rthz;
  const bool measured = has_imu_ && !imu_.empty();
  noise.gyro_walk = measured ? 0.0 : settings_.constant_velocity.rate_radps2_rthz;
  propagate_constant_velocity(state_, (t_end - state_.t).s(), noise);
  state_.t = t_end;
}

/// Before gravity is known the gyro already tells the turn rate, to its turn-on bias: sparse rings
/// see little of pitch and height in their first scans.
void RobustOdometry::turn_with_gyro(Time t_end) {
  const std::vector<sensor::ImuSample> samples = imu_.between(state_.t, t_end);
  if (samples.empty()) return;
  const double bias = 0.4 * settings_.initialisation.rest.gyro_mean_max_radps;
  state_.gyro_bias_radps = imu::statistics(samples).gyro_mean_radps;
  state_.P.middleRows<3>(kGyroBias).setZero();
  state_.P.middleCols<3>(kGyroBias).setZero();
  state_.P.diagonal().segment<3>(kGyroBias).setConstant(bias * bias);
}

SweepMotion RobustOdometry::sweep_motion(const LidarScan& scan) const {
  if (!scan.has_point_times || scan.deskewed) return SweepMotion(calibration_.T_body_lidar);
  if (inertial_) return SweepMotion(poses_, scan.t_begin, calibration_.T_body_lidar);
  // Constant velocity, backwards from the end with the newest estimate of the velocity.
  constexpr int kSteps = 10;
  const double span_s = (scan.t_end - scan.t_begin).s();
  std::vector<TimedPose> poses;
  for (int k = 0; k <= kSteps; ++k) {
    const double ago_s = span_s * (kSteps - k) / kSteps;
    const Vec3 turn = -ago_s * state_.gyro_bias_radps;
    SE3 T_end_then{geometry::so3_exp(turn),
                   -ago_s * (geometry::so3_right_jacobian(-turn) * state_.v)};
    poses.push_back({scan.t_end - Duration::from_s(ago_s), state_.T_odom_body * T_end_then});
  }
  return SweepMotion(poses, scan.t_begin, calibration_.T_body_lidar);
}

UpdateResult RobustOdometry::update(const LidarScan& scan, int rounds) {
  const FilterState predicted = state_;
  const Vec3 p_body_lidar = calibration_.T_body_lidar.p;
  UpdateResult done;
  SE3 start = state_.T_odom_body;
  for (int k = 0; k < rounds; ++k) {
    sweep_motion(scan).apply(scan, sampler_.update_indices(), points_);
    matcher_.set_points(points_, p_body_lidar);
    const Vec3 v = state_.v;
    const Vec3 w = state_.gyro_bias_radps;
    state_ = predicted;
    done = update_with_scan(state_, matcher_, map_, start, settings_, axes_, !inertial_);
    if (k == 0 && !inertial_) look_around(predicted, done);
    start = state_.T_odom_body;
    if ((state_.v - v).norm() < 0.05 && (state_.gyro_bias_radps - w).norm() < 0.01) break;
  }
  axes_ = done.axes;
  return done;
}

/// Without inertial data the prediction can be too poor for the registration to find the right
/// place: other places near the prediction are tried, and the best fit is taken.
void RobustOdometry::look_around(const FilterState& predicted, UpdateResult& done) {
  if (has_imu_) return;
  const Vec3 up = -state_.g_odom_mps2.normalized();
  const Vec3 up_body = predicted.T_odom_body.R.transpose() * up;
  PoseGuess guess;
  guess.T_odom_body = predicted.T_odom_body;
  guess.sigma_m = std::sqrt(predicted.P.block<2, 2>(kPos, kPos).diagonal().maxCoeff());
  guess.sigma_rad = std::sqrt(up_body.dot(predicted.P.block<3, 3>(kTheta, kTheta) * up_body));
  if (!needs_search(guess, settings_.search)) return;
  for (const SE3& start : search_pose(recent_, points_, guess, up, settings_.search)) {
    FilterState other = predicted;
    const UpdateResult elsewhere =
        update_with_scan(other, matcher_, map_, start, settings_, axes_, true);
    if (elsewhere.fit > 1.05 * done.fit) {
      done = elsewhere;
      state_ = other;
    }
  }
}

/// Keeps the sweep as it is without motion, in case the vehicle turns out to be standing: the
/// speed that the LiDAR alone guesses in its first scans would bend it.
void RobustOdometry::remember_start(const LidarScan& scan) {
  constexpr std::size_t kScansMax = 30;
  if (start_points_.size() < kScansMax) {
    const SweepMotion still(calibration_.T_body_lidar);
    still.apply(scan, sampler_.insert_indices(), start_points_.emplace_back());
  }
  const Time begin = track_.front().t;
  const imu::ImuStatistics blocks = imu::statistics(block_means(imu_.between(begin, state_.t)));
  const imu::RestSettings& rest = settings_.initialisation.rest;
  const double travel_m = (state_.T_odom_body.p - track_.front().T_odom_body.p).norm();
  const double sigma_m = std::sqrt(state_.P.block<3, 3>(kPos, kPos).diagonal().maxCoeff());
  const bool travelled =
      travel_m > std::max(settings_.initialisation.rest_travel_max_m, 3.0 * sigma_m);
  quiet_start_ = blocks.gyro_sd_radps.maxCoeff() < rest.gyro_sd_max_radps &&
                 blocks.accel_sd_mps2.maxCoeff() < rest.accel_sd_max_mps2 &&
                 !travelled;
}

/// Once gravity, velocity and biases can be solved for, the filter goes over to inertial data.
void RobustOdometry::try_initialise(FindingList& findings) {
  const double var_m2 = state_.P.block<3, 3>(kPos, kPos).diagonal().maxCoeff();
  track_.push_back({state_.t, state_.T_odom_body, std::sqrt(var_m2)});
  const auto guess = solve_initial(track_, imu_, settings_.initialisation, noise_);
  if (!guess) {
    const Time oldest = state_.t - Duration::from_s(settings_.initialisation.give_up_s + 1.0);
    std::erase_if(track_, [oldest](const TrackedPose& p) { return p.t < oldest; });
    imu_.drop_before(oldest);
    return;
  }
  inertial_ = true;
  state_.v = guess->v_odom_mps;
  state_.gyro_bias_radps = guess->gyro_bias_radps;
  state_.accel_bias_mps2 = guess->accel_bias_mps2;
  state_.g_odom_mps2 = guess->g_odom_mps2;
  const Mat6 pose = state_.P.topLeftCorner<6, 6>();
  state_.P.setZero();
  state_.P.topLeftCorner<6, 6>() = pose;
  const auto set = [this](int index, int n, double sigma) {
    state_.P.diagonal().segment(index, n).setConstant(sigma * sigma);
  };
  set(kVel, 3, guess->velocity_sigma_mps);
  set(kGyroBias, 3, guess->gyro_bias_sigma_radps);
  set(kAccelBias, 3, guess->accel_bias_sigma_mps2);
  set(kGravity, 2, guess->gravity_sigma_rad);
  if (guess->at_rest && quiet_start_) {
    // All scans so far were taken from one place: the first pose. The map of the first scan alone
    // was poor, and the poses found with it wander; begin again with all of them there.
    state_.T_odom_body = track_.front().T_odom_body;
    state_.P.topLeftCorner<6, 6>() = 1e-10 * Mat6::Identity();
    map_ = PlaneMap(settings_.map);
    recent_.clear();
    for (const BodyPoints& points : start_points_) {
      points_ = points;
      insert_points(state_.T_odom_body);
    }
  }
  start_points_.clear();
  track_.clear();
  Finding f;
  f.id = guess->at_rest ? "odometry.start_at_rest" : "odometry.start_in_motion";
  f.severity = Severity::kInfo;
  f.t = state_.t;
  f.text = guess->at_rest ? "gravity and gyro bias found at rest"
                          : "gravity, speed and gyro bias found while moving";
  findings.push_back(f);
}

void RobustOdometry::insert(const LidarScan& scan) {
  sweep_motion(scan).apply(scan, sampler_.insert_indices(), points_);
  insert_points(state_.T_odom_body);
  if (points_.size() > 0) ++scans_in_map_;
}

void RobustOdometry::insert_points(const SE3& T_odom_body) {
  const Mat3& R = T_odom_body.R;
  const Vec3 origin = calibration_.T_body_lidar.p;
  const double epoch = drift_.epoch();
  if (!has_imu_) recent_.add(points_, T_odom_body);
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Vec3 p(points_.x_m[i], points_.y_m[i], points_.z_m[i]);
    const Vec3 ray = R * (p - origin);
    const double inverse = 1.0 / std::max(1e-6, ray.norm());
    map_.insert(R * p + T_odom_body.p, (inverse * ray).cast<float>(), epoch);
  }
}

/// What the filter says about this scan, floored by what one registration can know (the filter
/// takes repeated looks at the same planes for independent), plus the error of the map there.
Mat6 RobustOdometry::covariance(const UpdateResult& update) {
  Mat6 local = state_.P.topLeftCorner<6, 6>();
  if (update.matches > 0) {
    Mat6 I = update.information;
    const double weak = 1.0 / (settings_.drift.sigma_max_m * settings_.drift.sigma_max_m);
    I.diagonal().array() += weak;
    const Mat6 single = I.inverse();
    local += single;
  }
  // A scan that matched nothing hangs on the newest generation, not on the first.
  const bool matched = update.matches >= settings_.update.matches_min;
  const double epoch = matched ? update.mean_epoch : static_cast<double>(drift_.epoch());
  return drift_.update(state_.T_odom_body, epoch, local);
}

void RobustOdometry::bound_biases(FindingList& findings) {
  const InitialisationSettings& init = settings_.initialisation;
  const double gyro = state_.gyro_bias_radps.norm();
  const double accel = state_.accel_bias_mps2.norm();
  const bool out = gyro > init.gyro_bias_bound_radps || accel > init.accel_bias_bound_mps2;
  if (out && !bias_reported_) {
    Finding f;
    f.id = "odometry.bias_bound";
    f.severity = Severity::kWarning;
    f.t = state_.t;
    f.text = fmt::format("inertial bias at its bound: gyro {:.3f} rad/s, accelerometer {:.2f} m/s2",
                         gyro, accel);
    f.effect = "speed and tilt may be wrong";
    f.remedy = "Check units, extrinsics and time offset with rali doctor.";
    findings.push_back(f);
    bias_reported_ = true;
  }
  if (gyro > init.gyro_bias_bound_radps) state_.gyro_bias_radps *= init.gyro_bias_bound_radps / gyro;
  if (accel > init.accel_bias_bound_mps2) {
    state_.accel_bias_mps2 *= init.accel_bias_bound_mps2 / accel;
  }
}

/// Good, weak (few matches), predicted (none), or diverged (for too long, or impossible).
void RobustOdometry::judge(const UpdateResult& update, FindingList& findings) {
  constexpr double kLost_s = 2.0;
  constexpr double kSpeedMax_mps = 80.0;
  const bool impossible = !state_.T_odom_body.p.allFinite() || !state_.T_odom_body.R.allFinite() ||
                          !state_.v.allFinite() || state_.v.norm() > kSpeedMax_mps;
  if (!impossible && update.matches >= settings_.update.matches_min) {
    track_state_ = update.matches >= 3 * settings_.update.matches_min ? TrackState::kGood
                                                                      : TrackState::kWeak;
    t_last_good_ = state_.t;
    return;
  }
  track_state_ = TrackState::kPredicted;
  if (!impossible && (state_.t - t_last_good_).s() < kLost_s) return;
  track_state_ = TrackState::kDiverged;
  restart(findings);
}

/// The first scan in an empty map defines where the map is: the filter knows its pose there
/// exactly, and what it did not know becomes an error of the whole map.
void RobustOdometry::begin_map() {
  drift_.add(state_.T_odom_body, state_.P.topLeftCorner<6, 6>());
  state_.P.topRows<6>().setZero();
  state_.P.leftCols<6>().setZero();
  state_.P.diagonal().head<6>().setConstant(1e-10);
}

/// The map no longer fits what is seen: a new map begins at the last believable pose.
void RobustOdometry::restart(FindingList& findings) {
  Finding f;
  f.id = "odometry.diverged";
  f.severity = Severity::kError;
  f.t = state_.t;
  f.text = fmt::format("lost for {:.1f} s: the LiDAR fits the map nowhere",
                       (state_.t - t_last_good_).s());
  f.effect = "this stretch is cut from the map; poses after it hang on a guess";
  findings.push_back(f);
  const Time now = state_.t;
  SE3 pose = last_good_;
  const Vec3 gravity = state_.g_odom_mps2;
  state_ = FilterState{};
  state_.t = now;
  state_.T_odom_body = pose;
  state_.g_odom_mps2 = gravity.allFinite() ? gravity : FilterState{}.g_odom_mps2;
  const ConstantVelocitySettings& cv = settings_.constant_velocity;
  state_.P.diagonal().segment<3>(kTheta).setConstant(0.01);
  state_.P.diagonal().segment<3>(kPos).setConstant(1.0);
  state_.P.diagonal().segment<3>(kVel).setConstant(cv.start_speed_mps * cv.start_speed_mps);
  state_.P.diagonal().segment<3>(kGyroBias).setConstant(cv.start_rate_radps * cv.start_rate_radps);
  inertial_ = false;
  track_.assign(1, {now, pose, 0.0});
  map_ = PlaneMap(settings_.map);
  recent_.clear();
  scans_in_map_ = 0;
  t_last_good_ = now;
}

ScanResult RobustOdometry::result_of(const LidarScan& scan, const UpdateResult& update) {
  ScanResult out;
  out.t = scan.t_end;
  out.state = track_state_;
  out.T_odom_body = quiet_start_ && !inertial_ ? track_.front().T_odom_body : state_.T_odom_body;
  out.v_odom_mps = inertial_ ? state_.v : Vec3(state_.T_odom_body.R * state_.v);
  out.covariance = covariance(update);
  out.lidar_information = update.information;
  out.planes = matcher_.evidence();
  if (update.matches > 0) out.directions = update.directions;
  out.matches = update.matches;
  out.iterations = update.iterations;
  out.residual_rms_m = update.residual_rms_m;
  if (track_state_ == TrackState::kGood || track_state_ == TrackState::kWeak) {
    last_good_ = state_.T_odom_body;
    if (!held_ && keyframer_.wants(out.T_odom_body)) {
      sweep_motion(scan).apply(scan, {}, points_);
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

}  // namespace

std::unique_ptr<Odometry> make_robust_odometry(const OdometrySettings& settings,
                                               const sensor::Calibration& calibration,
                                               bool has_imu) {
  return std::make_unique<RobustOdometry>(settings, calibration, has_imu);
}

}  // namespace rali::odometry
