#include "rali/odometry/paper/paper_odometry.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "rali/odometry/paper/pipeline.hpp"
#include "rali/odometry/paper/weights.hpp"

namespace rali::odometry {
namespace paper {

using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;
using sensor::LidarScan;

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
// Largest distance of a scan from its prediction at which its matches can be correct.
constexpr double kJumpM = 2.0;
constexpr double kJumpRad = 20.0 * kDegree;
constexpr double kLostS = 2.0;
constexpr int kGoodFactor = 3;  // a good registration has this many times the minimum of matches
constexpr double kStartWindowS = 1.0;
// In degenerate stretches inertial data alone propagate the pose. A map that tilts as it grows then
// projects gravity into the acceleration, like a bias with this random walk [m/s^3/rtHz].
constexpr double kLevelWalk = 0.02;

/// Noise from data sheets is corrected by prior_noise(), except in literal mode.
ImuNoiseSettings noise_of(const OdometrySettings& settings) {
  ImuNoiseSettings noise = settings.imu_noise;
  if (settings.paper.literal) return noise;
  const imu::NoiseDensity density =
      imu::prior_noise({noise.vibration_factor * noise.gyro_radps_rthz,
                        noise.vibration_factor * noise.accel_mps2_rthz},
                       settings.robust.motion_noise);
  noise.gyro_radps_rthz = density.gyro_radps_rthz;
  noise.accel_mps2_rthz = density.accel_mps2_rthz;
  noise.vibration_factor = 1.0;
  return noise;
}

}  // namespace

PaperOdometry::PaperOdometry(const OdometrySettings& settings,
                             const sensor::Calibration& calibration, bool has_imu)
    : settings_(settings.paper.resolved()),
      T_body_lidar_(calibration.T_body_lidar),
      has_imu_(has_imu),
      guess_(noise_of(settings), calibration.T_body_imu, settings_.velocity_gain,
             settings_.bias_gain),
      submap_(2.0 * settings_.downsample_m, settings_.map_normal_max_deg * kDegree, settings_.n_kf,
              settings_.keyframes_kept_max),
      registration_(settings_),
      keyframer_(settings_.keyframe_overlap, 2.0 * settings_.downsample_m, T_body_lidar_),
      standing_(settings.robust, settings.imu_noise.gyro_radps_rthz) {
  const ImuNoiseSettings noise = noise_of(settings);
  inertial_noise_ = {noise.vibration_factor * noise.gyro_radps_rthz,
                     noise.vibration_factor * noise.accel_mps2_rthz};
}

void PaperOdometry::add_imu(const sensor::ImuSample& sample) {
  if (!has_imu_) return;
  guess_.add(sample);
  if (const sensor::ImuSample* taken = guess_.newest_sample()) standing_.add(*taken);
}

ScanResult PaperOdometry::process(const LidarScan& scan, Executor& executor,
                                  FindingList& findings) {
  ScanResult out;
  out.t = scan.t_end;
  if (!started_) {
    if (!start(scan, findings)) return out;
  } else if (scan.t_end <= t_last_) {
    // Time must not run backwards: the caller orders scans, this one is ignored.
    out.T_odom_body = guess_.T_odom_body();
    out.covariance = covariance_;
    out.state = TrackState::kPredicted;
    return out;
  }
  guess_.predict(scan.t_end, path_);
  t_last_ = scan.t_end;
  if (has_imu_ && !guess_.inertial() && path_.size() > 1) {
    note(findings, reported_no_imu_, "odometry.imu_gap", scan.t_end,
         "no inertial samples for more than half of a scan", "constant velocity is assumed there",
         "");
  }
  undistort(scan);
  find_features(scan, findings);
  find_degenerate_direction();
  register_scan(scan, executor, findings, out);
  stand_if_standing(out);
  out.T_odom_body_predicted = predicted_;
  if (reported_before_) out.T_last_predicted = reported_before_->inverse() * predicted_;
  out.v_odom_mps = guess_.v_odom_body_mps();
  out.inertial = has_imu_;
  out.inertial_noise = inertial_noise_;
  out.gyro_bias_radps = guess_.bias().gyro_radps;
  out.accel_bias_mps2 = guess_.bias().accel_mps2;
  covariance_ = guess_.covariance() + map_error_.at(out.T_odom_body);
  out.covariance = covariance_;
  out.planes = registration_.evidence();
  out.feature_normals_body = normals_body_;
  keyframe_if_wanted(scan, findings, out);
  report_if_lost(scan.t_end, findings);
  reported_before_ = out.T_odom_body;
  return out;
}

bool PaperOdometry::start(const LidarScan& scan, FindingList& findings) {
  if (!has_imu_) {
    guess_.reset(scan.t_end, {});
  } else {
    using Start = InertialGuess::Start;
    const Start how = guess_.try_start(scan.t_end, findings);
    if (how == Start::kWait) return false;
    started_at_rest_ = how == Start::kAtRest;
    if (started_at_rest_) {
      standing_.learn(scan.t_end - Duration::from_s(kStartWindowS), scan.t_end);
    }
    bool unsaid = false;
    if (!started_at_rest_) {
      note(findings, unsaid, "odometry.start_in_motion", scan.t_end,
           "the vehicle moves at the start: level is the mean acceleration of the first second",
           "the map may be tilted by some degrees, the gyro bias is taken as 0",
           "Start the recording with a second at rest.");
    }
  }
  started_ = true;
  t_last_ = scan.t_end;
  t_last_registered_ = scan.t_end;
  last_registered_ = guess_.T_odom_body();
  return true;
}

void PaperOdometry::undistort(const LidarScan& scan) {
  const SE3 still;
  if (settings_.deskew == PaperDeskew::kNone || path_.size() < 2) {
    ScanMotion(still).apply(scan, {}, cloud_lidar_);
    return;
  }
  // The path of the LiDAR itself, so that the points stay in its frame, where rings are cones.
  const Vec3 p_end = (path_.back().T_odom_body * T_body_lidar_).p;
  lidar_path_.clear();
  for (const TimedPose& pose : path_) {
    SE3 T_odom_lidar = pose.T_odom_body * T_body_lidar_;
    if (settings_.deskew == PaperDeskew::kRotation) T_odom_lidar.p = p_end;
    lidar_path_.push_back({pose.t, T_odom_lidar});
  }
  ScanMotion(lidar_path_, scan.t_start, still).apply(scan, {}, cloud_lidar_);
}

void PaperOdometry::find_features(const LidarScan& scan, FindingList& findings) {
  const PlanarFeatureSettings how{settings_.downsample_m, settings_.theta_planar_deg};
  const PointsView view{cloud_lidar_.x_m, cloud_lidar_.y_m, cloud_lidar_.z_m, scan.ring};
  extractor_.extract(view, how, features_);
  if (!scan.has_rings && scan.size() > 0) {
    note(findings, reported_no_rings_, "odometry.no_rings", scan.t_end,
         "the LiDAR gives no ring of its points, which the paper's features need",
         "normals are fitted to scattered points instead", "Use preset robust for this sensor.");
    scattered_.extract(view, extractor_.thinned(), how, features_);
  }
  const bool raw = settings_.normal_sign == PaperNormalSign::kRaw;
  normals_body_.clear();
  for (std::size_t i = 0; i < features_.size(); ++i) {
    const double sign = raw && features_.turned[i] != 0 ? -1.0 : 1.0;
    normals_body_.push_back(
        sign * (T_body_lidar_.R *
                geometry::Vec3f(features_.nx[i], features_.ny[i], features_.nz[i]).cast<double>()));
  }
}

void PaperOdometry::find_degenerate_direction() {
  const std::optional<Vec3> before = degenerate_odom_;
  degenerate_odom_.reset();
  if (corrector_ != nullptr && settings_.degenerate_step == PaperDegenerateStep::kPredicted) {
    const SE3 guess = guess_.T_odom_body();
    const Vec3 up_body = guess.R.row(2).transpose();
    const auto direction = corrector_->degenerate_direction(normals_body_, up_body);
    if (direction) degenerate_odom_ = guess.R * *direction;
    if (direction && has_imu_) guess_.let_accel_bias_wander(kLevelWalk);
  }
  registration_.hold_along(degenerate_odom_);
  degenerate_ended_ = before && !degenerate_odom_;
  if (degenerate_ended_) remember_open_error(before);
}

// The next registration gives the pose in the map, but not the error that the map accumulated while
// it was unconstrained.
void PaperOdometry::remember_open_error(const std::optional<Vec3>& open_before) {
  const Mat6 P = guess_.covariance();
  map_error_.add_along(*open_before, open_before->dot(P.bottomRightCorner<3, 3>() * *open_before));
}

void PaperOdometry::register_scan(const LidarScan& scan, Executor& executor, FindingList& findings,
                                  ScanResult& out) {
  const SE3 guess = guess_.T_odom_body();
  predicted_ = guess;
  if (submap_.keyframes() == 0) {
    out.state = features_.size() > 0 ? TrackState::kGood : TrackState::kPredicted;
    out.T_odom_body = guess;
    guess_.correct(guess);
    return;
  }
  submap_.select_near(guess.p);
  const double turn_rad = rotation_angle_rad(guess_.rotation_since_last(), settings_.rot_angle);
  const RegistrationResult done =
      registration_.align(features_, T_body_lidar_, guess,
                          turn_rad > settings_.theta_th_deg * kDegree, submap_, executor);
  out.matches = done.matches;
  out.iterations = done.iterations;
  out.residual_rms_m = done.residual_rms_m;
  const geometry::Vec6 jump = geometry::boxminus(done.T_odom_body, guess);
  const bool believable =
      jump.allFinite() && jump.head<3>().norm() < kJumpRad && jump.tail<3>().norm() < kJumpM;
  if (!done.matched || !believable) {
    keep_prediction(scan, findings, out);
    return;
  }
  out.state =
      done.matches >= kGoodFactor * settings_.matches_min ? TrackState::kGood : TrackState::kWeak;
  out.lidar_information = done.information;
  take_over(done);
  out.T_odom_body = guess_.T_odom_body();
  last_registered_ = out.T_odom_body;
  t_last_registered_ = scan.t_end;
}

void PaperOdometry::take_over(const RegistrationResult& done) {
  const Mat6 assumed = settings_.registration_fraction * done.information;
  if (has_imu_ && settings_.back_end == PaperBackEnd::kGraph) {
    guess_.fuse(assumed, settings_.registration_fraction * done.pull);
  } else {
    guess_.correct(done.T_odom_body);
    guess_.fuse_covariance(assumed);
  }
}

void PaperOdometry::stand_if_standing(ScanResult& out) {
  if (!has_imu_ || !guess_.inertial() || out.state == TrackState::kDiverged) return;
  if (!standing_.update(out.t, guess_, degenerate_odom_, stands_at_)) return stands_at_.reset();
  if (!stands_at_) {
    stands_at_ = guess_.T_odom_body();
    guess_.start_standstill();
  }
  guess_.stay(*stands_at_);
  out.T_odom_body = *stands_at_;
  out.at_rest = true;
}

void PaperOdometry::keep_prediction(const LidarScan& scan, FindingList& findings, ScanResult& out) {
  out.state = TrackState::kPredicted;
  out.T_odom_body = guess_.T_odom_body();
  if (seconds_between(t_last_registered_, scan.t_end) > kLostS && features_.size() > 0) {
    restart(scan, findings, out);
  }
}

// The map matches nowhere any more: a new one starts at the last registered pose.
void PaperOdometry::restart(const LidarScan& scan, FindingList& findings, ScanResult& out) {
  bool unsaid = false;
  note(findings, unsaid, "odometry.diverged", scan.t_end,
       fmt::format("lost for {:.1f} s: the LiDAR fits the map nowhere",
                   seconds_between(t_last_registered_, scan.t_end)),
       "this stretch is missing in the map; poses after it hang on a guess", "");
  findings.back().severity = Severity::kError;
  out.state = TrackState::kDiverged;
  out.T_odom_body = last_registered_;
  guess_.reset(scan.t_end, last_registered_);
  submap_.clear();
  keyframer_.clear_overlap();
  map_error_.lose();
  stands_at_.reset();
  standing_.reset();
  t_last_registered_ = scan.t_end;
}

}  // namespace paper

std::unique_ptr<Odometry> make_paper_odometry(const OdometrySettings& settings,
                                              const sensor::Calibration& calibration,
                                              bool has_imu) {
  return std::make_unique<paper::PaperOdometry>(settings, calibration, has_imu);
}

}  // namespace rali::odometry
