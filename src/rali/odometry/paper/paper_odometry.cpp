#include "rali/odometry/paper/paper_odometry.hpp"

#include <bit>
#include <cmath>
#include <numbers>

#include <Eigen/LU>
#include <fmt/format.h>

#include "rali/odometry/paper/inertial_guess.hpp"
#include "rali/odometry/paper/keyframer.hpp"
#include "rali/odometry/paper/planar_features.hpp"
#include "rali/odometry/paper/registration.hpp"
#include "rali/odometry/paper/scattered_features.hpp"
#include "rali/odometry/paper/submap.hpp"
#include "rali/odometry/paper/weights.hpp"

namespace rali::odometry {
namespace {

using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;
using sensor::LidarScan;

constexpr double kDegree = std::numbers::pi / 180.0;
// The scan cannot be further from its prediction than this and still have matched rightly.
constexpr double kJumpM = 2.0;
constexpr double kJumpRad = 20.0 * kDegree;
// What is assumed of a pose that no match supports (per scan), and the loosest prior of any pose.
constexpr double kPredictedSigmaM = 0.1;
constexpr double kPredictedSigmaRad = 0.5 * kDegree;
constexpr double kLooseSigmaM = 1.0;
constexpr double kLooseSigmaRad = 10.0 * kDegree;
constexpr double kLostS = 2.0;
constexpr int kGoodFactor = 3;  // so many times the least matches are a good registration

Mat6 diagonal(double sigma_rad, double sigma_m) {
  Mat6 out = Mat6::Zero();
  out.diagonal().head<3>().setConstant(sigma_rad * sigma_rad);
  out.diagonal().tail<3>().setConstant(sigma_m * sigma_m);
  return out;
}

// The paper leaves the covariance undefined (finding F10): information of the matches, with a
// loose prior so that it exists along blind directions.
Mat6 covariance_of(const Mat6& information) {
  const Mat6 prior = diagonal(1.0 / kLooseSigmaRad, 1.0 / kLooseSigmaM);
  const Mat6 covariance = (information + prior).inverse();
  return 0.5 * (covariance + covariance.transpose());
}

/// Data sheets are taken for what they are, unless the paper is followed to the letter.
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

class PaperOdometry final : public Odometry {
 public:
  PaperOdometry(const OdometrySettings& settings, const sensor::Calibration& calibration,
                bool has_imu)
      : settings_(settings.paper.resolved()),
        T_body_lidar_(calibration.T_body_lidar),
        has_imu_(has_imu),
        guess_(noise_of(settings), calibration.T_body_imu, settings_.velocity_gain,
               settings_.bias_gain),
        submap_(2.0 * settings_.downsample_m, settings_.map_normal_max_deg * kDegree,
                settings_.n_kf, settings_.keyframes_kept_max),
        registration_(settings_),
        keyframer_(settings_.keyframe_overlap, 2.0 * settings_.downsample_m, T_body_lidar_) {}

  void add_imu(const sensor::ImuSample& sample) override {
    if (has_imu_) guess_.add(sample);
  }

  ScanResult process(const LidarScan& scan, Executor& executor, FindingList& findings) override;

  [[nodiscard]] Vec3 gravity_odom() const override { return paper::kGravityOdom; }

  [[nodiscard]] geometry::Mat3 gravity_covariance() const override {
    geometry::Mat3 C = geometry::Mat3::Zero();
    if (has_imu_) C.diagonal() << tilt_variance(), tilt_variance(), 0.0;
    return C;
  }

  void correct_keyframes_by(KeyframeCorrector* corrector) override { corrector_ = corrector; }

  [[nodiscard]] std::uint64_t state_hash() const override;

 private:
  // Odom's z axis is the mean force of the start: its error is that of the tilt found there.
  [[nodiscard]] double tilt_variance() const {
    const double sigma_mps2 = started_at_rest_ ? 0.05 : 0.5;
    return sigma_mps2 * sigma_mps2;
  }

  bool start(const LidarScan& scan, FindingList& findings);
  void undistort(const LidarScan& scan);
  void find_features(const LidarScan& scan, FindingList& findings);
  void register_scan(const LidarScan& scan, Executor& executor, FindingList& findings,
                     ScanResult& out);
  void take_over(const paper::RegistrationResult& done);
  void keep_prediction(const LidarScan& scan, FindingList& findings, ScanResult& out);
  void restart(const LidarScan& scan, FindingList& findings, ScanResult& out);
  void keyframe_if_wanted(const LidarScan& scan, FindingList& findings, ScanResult& out);
  void take_move(const KeyframeMove& move, ScanResult& out);
  void note(FindingList& findings, bool& said, const char* id, Time t, std::string text,
            std::string effect, std::string remedy);

  PaperSettings settings_;
  SE3 T_body_lidar_;
  bool has_imu_;
  bool started_ = false;
  bool started_at_rest_ = false;

  paper::InertialGuess guess_;
  paper::PlanarFeatureExtractor extractor_;
  paper::ScatteredFeatureExtractor scattered_;
  paper::Submap submap_;
  paper::Registration registration_;
  paper::OverlapKeyframer keyframer_;
  KeyframeCorrector* corrector_ = nullptr;

  std::vector<TimedPose> path_;  // of the body over the last prediction
  std::vector<TimedPose> lidar_path_;
  BodyPoints cloud_lidar_;  // LiDAR frame at the end of the sweep
  paper::PlanarFeatures features_;
  std::vector<Vec3> normals_body_;
  Mat6 covariance_ = Mat6::Zero();
  SE3 predicted_;
  std::optional<SE3> told_before_;  // pose of the last scan
  SE3 last_registered_;
  Time t_last_registered_;
  Time t_last_;
  bool said_no_rings_ = false;
  bool said_no_imu_ = false;
  bool said_forgets_ = false;
};

ScanResult PaperOdometry::process(const LidarScan& scan, Executor& executor,
                                  FindingList& findings) {
  ScanResult out;
  out.t = scan.t_end;
  if (!started_) {
    if (!start(scan, findings)) return out;
  } else if (scan.t_end <= t_last_) {
    // Time does not run backwards here: the caller orders scans, this one adds nothing.
    out.T_odom_body = guess_.T_odom_body();
    out.covariance = covariance_;
    out.state = TrackState::kPredicted;
    return out;
  }
  guess_.predict(scan.t_end, path_);
  t_last_ = scan.t_end;
  if (has_imu_ && !guess_.inertial() && path_.size() > 1) {
    note(findings, said_no_imu_, "odometry.imu_gap", scan.t_end,
         "no inertial samples for more than half of a sweep", "constant velocity is assumed there",
         "");
  }
  undistort(scan);
  find_features(scan, findings);
  register_scan(scan, executor, findings, out);
  out.T_odom_body_predicted = predicted_;
  if (told_before_) out.T_last_predicted = told_before_->inverse() * predicted_;
  out.v_odom_mps = guess_.v_odom_body_mps();
  out.covariance = covariance_;
  out.planes = registration_.evidence();
  out.feature_normals_body = normals_body_;
  keyframe_if_wanted(scan, findings, out);
  told_before_ = out.T_odom_body;
  return out;
}

bool PaperOdometry::start(const LidarScan& scan, FindingList& findings) {
  if (!has_imu_) {
    guess_.reset(scan.t_end, {});
  } else {
    using Start = paper::InertialGuess::Start;
    const Start how = guess_.try_start(scan.t_end, findings);
    if (how == Start::kWait) return false;
    started_at_rest_ = how == Start::kAtRest;
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
  covariance_ = diagonal(1e-5, 1e-5);
  return true;
}

void PaperOdometry::undistort(const LidarScan& scan) {
  const SE3 still;
  if (settings_.deskew == PaperDeskew::kNone || path_.size() < 2) {
    SweepMotion(still).apply(scan, {}, cloud_lidar_);
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
  SweepMotion(lidar_path_, scan.t_begin, still).apply(scan, {}, cloud_lidar_);
}

void PaperOdometry::find_features(const LidarScan& scan, FindingList& findings) {
  const paper::PlanarFeatureSettings how{settings_.downsample_m, settings_.theta_planar_deg};
  const paper::PointsView view{cloud_lidar_.x_m, cloud_lidar_.y_m, cloud_lidar_.z_m, scan.ring};
  extractor_.extract(view, how, features_);
  if (!scan.has_rings && scan.size() > 0) {
    note(findings, said_no_rings_, "odometry.no_rings", scan.t_end,
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
  const double turn_rad =
      paper::rotation_angle_rad(guess_.rotation_since_last(), settings_.rot_angle);
  const paper::RegistrationResult done =
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

void PaperOdometry::take_over(const paper::RegistrationResult& done) {
  if (has_imu_ && settings_.back_end == PaperBackEnd::kGraph) {
    guess_.fuse(settings_.registration_share * done.information,
                settings_.registration_share * done.pull);
    covariance_ = guess_.covariance();
  } else {
    guess_.correct(done.T_odom_body);
    covariance_ = covariance_of(done.information);
  }
}

void PaperOdometry::keep_prediction(const LidarScan& scan, FindingList& findings, ScanResult& out) {
  out.state = TrackState::kPredicted;
  out.T_odom_body = guess_.T_odom_body();
  covariance_ += diagonal(kPredictedSigmaRad, kPredictedSigmaM);
  if (seconds_between(t_last_registered_, scan.t_end) > kLostS && features_.size() > 0) {
    restart(scan, findings, out);
  }
}

// The map fits nowhere any more: a new one begins at the last pose that was registered.
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
  covariance_ = diagonal(kLooseSigmaRad, kLooseSigmaM);
  t_last_registered_ = scan.t_end;
}

void PaperOdometry::keyframe_if_wanted(const LidarScan& scan, FindingList& findings,
                                       ScanResult& out) {
  if (features_.size() < 3) return;
  const double overlap = keyframer_.overlap(cloud_lidar_, extractor_.thinned(), out.T_odom_body);
  const bool due = keyframer_.is_due(scan.t_end, out.T_odom_body, settings_.keyframe_s);
  if (!keyframer_.wants(overlap) && !due) return;
  if (corrector_ != nullptr) {
    const KeyframeInertia inertia{predicted_, guess_.motion(),
                                  has_imu_ ? guess_.since_keyframe() : nullptr};
    if (const auto move = corrector_->at_keyframe(out, inertia)) take_move(*move, out);
    guess_.begin_keyframe();
  }
  out.keyframe = keyframer_.make(scan, cloud_lidar_, extractor_.thinned(), out);
  std::vector<paper::PointNormal> stored;
  stored.reserve(features_.size());
  const Eigen::Matrix3f R = T_body_lidar_.R.cast<float>();
  const geometry::Vec3f p = T_body_lidar_.p.cast<float>();
  for (std::size_t i = 0; i < features_.size(); ++i) {
    const geometry::Vec3f at(features_.x_m[i], features_.y_m[i], features_.z_m[i]);
    const geometry::Vec3f n(features_.nx[i], features_.ny[i], features_.nz[i]);
    stored.push_back({R * at + p, R * n});
  }
  submap_.add_keyframe(out.T_odom_body, std::move(stored));
  if (submap_.forgotten() > 0) {
    note(findings, said_forgets_, "odometry.keyframes_full", scan.t_end,
         fmt::format("more than {} keyframes: the oldest leave the odometry's map",
                     settings_.keyframes_kept_max),
         "places seen first are new when they are seen again",
         "Raise odometry.paper.keyframes_kept_max.");
  }
}

void PaperOdometry::take_move(const KeyframeMove& move, ScanResult& out) {
  submap_.move_newest(move.earlier);
  if (!move.earlier.empty()) keyframer_.move_last(move.earlier.back());
  const SE3 T_new_old = move.T_odom_body * out.T_odom_body.inverse();
  guess_.move(T_new_old);
  if (move.motion && has_imu_) guess_.set_motion(*move.motion);
  last_registered_ = T_new_old * last_registered_;
  out.T_odom_body = guess_.T_odom_body();
  out.v_odom_mps = guess_.v_odom_body_mps();
}

void PaperOdometry::note(FindingList& findings, bool& said, const char* id, Time t,
                         std::string text, std::string effect, std::string remedy) {
  if (said) return;
  said = true;
  Finding f;
  f.id = id;
  f.t = t;
  f.text = std::move(text);
  f.effect = std::move(effect);
  f.remedy = std::move(remedy);
  findings.push_back(std::move(f));
}

std::uint64_t PaperOdometry::state_hash() const {
  std::uint64_t h = 0xcbf29ce484222325ULL;  // FNV-1a over 64-bit words
  const auto mix = [&h](std::uint64_t v) { h = (h ^ v) * 0x100000001b3ULL; };
  const auto mix_real = [&mix](double v) { mix(std::bit_cast<std::uint64_t>(v)); };
  const SE3 T = guess_.T_odom_body();
  for (int k = 0; k < 9; ++k) mix_real(T.R.data()[k]);
  for (int k = 0; k < 3; ++k) {
    mix_real(T.p(k));
    mix_real(guess_.v_odom_body_mps()(k));
    mix_real(guess_.bias().gyro_radps(k));
    mix_real(guess_.bias().accel_mps2(k));
  }
  for (int k = 0; k < 36; ++k) mix_real(covariance_.data()[k]);
  mix(submap_.keyframes());
  mix(submap_.points());
  mix(static_cast<std::uint64_t>(t_last_.ns));
  return h;
}

}  // namespace

std::unique_ptr<Odometry> make_paper_odometry(const OdometrySettings& settings,
                                              const sensor::Calibration& calibration,
                                              bool has_imu) {
  return std::make_unique<PaperOdometry>(settings, calibration, has_imu);
}

}  // namespace rali::odometry
