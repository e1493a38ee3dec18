#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rali/odometry/odometry.hpp"
#include "rali/odometry/paper/inertial_guess.hpp"
#include "rali/odometry/paper/keyframer.hpp"
#include "rali/odometry/paper/map_error.hpp"
#include "rali/odometry/paper/planar_features.hpp"
#include "rali/odometry/paper/registration.hpp"
#include "rali/odometry/paper/scattered_features.hpp"
#include "rali/odometry/paper/standing.hpp"
#include "rali/odometry/paper/submap.hpp"
#include "rali/odometry/settings.hpp"

namespace rali::odometry::paper {

/// The paper's LiDAR-inertial odometry (section "LiDAR-inertial Odometry"): features, prediction by
/// preintegration, registration, keyframes. A corrector applies ranges to keyframes.
class PaperOdometry final : public Odometry {
 public:
  PaperOdometry(const OdometrySettings& settings, const sensor::Calibration& calibration,
                bool has_imu);

  void add_imu(const sensor::ImuSample& sample) override;

  ScanResult process(const sensor::LidarScan& scan, Executor& executor,
                     FindingList& findings) override;

  [[nodiscard]] geometry::Vec3 gravity_odom() const override { return kGravityOdom; }

  [[nodiscard]] geometry::Mat3 gravity_covariance() const override {
    geometry::Mat3 C = geometry::Mat3::Zero();
    if (has_imu_) C.diagonal() << tilt_variance(), tilt_variance(), 0.0;
    return C;
  }

  void correct_keyframes_by(KeyframeCorrector* corrector) override { corrector_ = corrector; }

  [[nodiscard]] std::uint64_t state_hash() const override;

 private:
  // Odom's z axis is the mean force of the start: its error is the tilt error of the start.
  [[nodiscard]] double tilt_variance() const {
    const double sigma_mps2 = started_at_rest_ ? 0.05 : 0.5;
    return sigma_mps2 * sigma_mps2;
  }

  bool start(const sensor::LidarScan& scan, FindingList& findings);
  void undistort(const sensor::LidarScan& scan);
  void find_features(const sensor::LidarScan& scan, FindingList& findings);
  void find_degenerate_direction();
  void register_scan(const sensor::LidarScan& scan, Executor& executor, FindingList& findings,
                     ScanResult& out);
  void take_over(const RegistrationResult& done);
  void remember_open_error(const std::optional<geometry::Vec3>& open_before);
  void stand_if_standing(ScanResult& out);
  void report_if_lost(Time t, FindingList& findings);
  void keep_prediction(const sensor::LidarScan& scan, FindingList& findings, ScanResult& out);
  void restart(const sensor::LidarScan& scan, FindingList& findings, ScanResult& out);
  [[nodiscard]] double keyframe_due_s() const;
  void keyframe_if_wanted(const sensor::LidarScan& scan, FindingList& findings, ScanResult& out);
  void take_move(const KeyframeMove& move, ScanResult& out);
  void note(FindingList& findings, bool& reported, const char* id, Time t, std::string text,
            std::string effect, std::string remedy);

  PaperSettings settings_;
  geometry::SE3 T_body_lidar_;
  bool has_imu_;
  bool started_ = false;
  bool started_at_rest_ = false;

  InertialGuess guess_;
  PlanarFeatureExtractor extractor_;
  ScatteredFeatureExtractor scattered_;
  Submap submap_;
  Registration registration_;
  OverlapKeyframer keyframer_;
  KeyframeCorrector* corrector_ = nullptr;

  std::vector<TimedPose> path_;  // of the body over the last prediction
  std::vector<TimedPose> lidar_path_;
  BodyPoints cloud_lidar_;  // LiDAR frame at the end of the scan
  PlanarFeatures features_;
  std::vector<geometry::Vec3> normals_body_;
  /// Of this scan, unit, in odom at the predicted pose.
  std::optional<geometry::Vec3> degenerate_odom_;
  bool degenerate_ended_ = false;  ///< the degenerate stretch ended with this scan
  geometry::Mat6 covariance_ = geometry::Mat6::Zero();  // of this scan, the map's error included
  MapError map_error_;
  Standing standing_;
  std::optional<geometry::SE3> stands_at_;
  imu::NoiseDensity inertial_noise_;
  double reported_lost_m_ = 0.0;  // last sigma reported as a finding
  geometry::SE3 predicted_;
  std::optional<geometry::SE3> reported_before_;  // pose of the last scan
  geometry::SE3 last_registered_;
  Time t_last_registered_;
  Time t_last_;
  bool reported_no_rings_ = false;
  bool reported_no_imu_ = false;
  bool reported_forgets_ = false;
};

}  // namespace rali::odometry::paper
