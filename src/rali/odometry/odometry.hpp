#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/base/finding.hpp"
#include "rali/degeneracy/evidence.hpp"
#include "rali/degeneracy/report.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/imu/motion_noise.hpp"
#include "rali/imu/preintegration.hpp"
#include "rali/odometry/augmented_filter.hpp"
#include "rali/odometry/keyframe.hpp"
#include "rali/sensor/calibration.hpp"
#include "rali/sensor/imu_sample.hpp"
#include "rali/sensor/lidar_scan.hpp"

namespace rali::odometry {

enum class TrackState { kWaiting, kGood, kWeak, kPredicted, kDiverged };

/// Estimate of one scan. Vectors point into the odometry and are valid until the next process().
struct ScanResult {
  Time t;  ///< of the last point
  TrackState state = TrackState::kWaiting;
  geometry::SE3 T_odom_body;
  geometry::SE3 T_odom_body_predicted;  ///< before this scan was registered
  geometry::SE3 T_last_predicted;       ///< motion since the last scan, by prediction alone
  bool new_map = false;  ///< the map was lost; the pose is that of the last good match
  geometry::Vec3 v_odom_mps = geometry::Vec3::Zero();
  geometry::Vec3 gyro_bias_radps = geometry::Vec3::Zero();  ///< in the IMU
  geometry::Vec3 accel_bias_mps2 = geometry::Vec3::Zero();  ///< in the IMU
  imu::NoiseDensity inertial_noise;   ///< of the inertial data, as the estimator uses it
  imu::MeasuredNoise measured_noise;  ///< of the inertial data, while driving
  /// Of the specific force expected at constant speed, accelerometer bias and gravity together, in
  /// its worst direction; 0: not known.
  double force_sigma_mps2 = 0.0;
  bool inertial = false;  ///< gravity and biases are initialised, the pose uses inertial data too
  geometry::Mat6 covariance = geometry::Mat6::Zero();         ///< of geometry::boxplus
  geometry::Mat6 lidar_information = geometry::Mat6::Zero();  ///< boxplus order, without prior
  std::span<const degeneracy::PlaneEvidence> planes;
  /// Axial, lateral, vertical, roll, pitch, yaw of this scan, if the odometry computes them.
  std::optional<std::array<degeneracy::DirectionInfo, 6>> directions;
  std::span<const geometry::Vec3> feature_normals_body;  ///< paper's ring-neighbour normals
  bool at_rest = false;                                  ///< standstill, the pose is kept fixed
  int matches = 0;
  int iterations = 0;
  double residual_rms_m = 0.0;
  std::shared_ptr<const Keyframe> keyframe;  ///< set if this scan became one
};

/// Estimate from inertial data: the velocity of the IMU in odom and the biases.
struct KeyframeMotion {
  geometry::Vec3 v_odom_imu_mps = geometry::Vec3::Zero();
  imu::InertialBias bias;
};

/// Inertial estimates at a keyframe, besides its scan.
struct KeyframeInertia {
  geometry::SE3 T_odom_body_predicted;  ///< before registration
  KeyframeMotion motion;
  const imu::Preintegration* since_last =
      nullptr;  ///< from the last keyframe; null if samples are missing
};

/// A position measured along one direction; the pose was shifted to the measured value.
struct KnownAlong {
  geometry::Vec3 e_odom = geometry::Vec3::UnitX();  ///< unit
  double shift_m = 0.0;                             ///< along e_odom
  double sigma_m = 0.0;                             ///< of the measurement
  double place_sigma_m = 0.0;                       ///< of the landmark it was measured from
};

/// Keyframe poses after correction by a measurement. All in odom.
struct KeyframeMove {
  geometry::SE3 T_odom_body;           ///< of the keyframe given to the corrector
  std::vector<geometry::SE3> earlier;  ///< of those before it, oldest first; may be fewer than kept
  std::optional<KeyframeMotion> motion;  ///< at the keyframe; nothing: as it was
  std::optional<KnownAlong> known;       ///< measured part of the keyframe's position
};

/// Corrects keyframe poses by measurements other than LiDAR and IMU.
class KeyframeCorrector {
 public:
  virtual ~KeyframeCorrector() = default;

  /// Called once for each scan, before its registration.
  /// @return unit direction in the body along which the scan's normals do not constrain the
  ///         position; nothing if there is none
  [[nodiscard]] virtual std::optional<geometry::Vec3> degenerate_direction(
      std::span<const geometry::Vec3> /*normals_body*/, const geometry::Vec3& /*up_body*/) const {
    return std::nullopt;
  }

  /// Called once for each scan that becomes a keyframe, after its registration and before it enters
  /// the map. The odometry continues from the returned pose.
  /// @return nothing: no change
  virtual std::optional<KeyframeMove> at_keyframe(const ScanResult& scan,
                                                  const KeyframeInertia& inertia) = 0;
};

/// LiDAR(-inertial) odometry of one vehicle. Both presets are implementations of it.
class Odometry {
 public:
  virtual ~Odometry() = default;

  /// Inertial samples in time order; the caller rejects samples older than the last.
  virtual void add_imu(const sensor::ImuSample& sample) = 0;

  /// Processes one scan. The caller has delivered all IMU samples up to its end. `findings`
  /// receives messages for the user (divergence, saturation, ...).
  virtual ScanResult process(const sensor::LidarScan& scan, Executor& executor,
                             FindingList& findings) = 0;

  /// Call after the last scan: closes what is still open when the data end.
  virtual void finish(FindingList& /*findings*/) {}

  /// Gravity in odom at the first pose [m/s^2] and its covariance; (0,0,-9.81) with zero covariance
  /// without IMU.
  [[nodiscard]] virtual geometry::Vec3 gravity_odom() const = 0;
  [[nodiscard]] virtual geometry::Mat3 gravity_covariance() const = 0;

  /// Access for measurements between scans; null if this odometry has none.
  [[nodiscard]] virtual AugmentedFilter* augmented_filter() { return nullptr; }

  /// Calls `corrector` for each scan that becomes a keyframe. Null: none. Not owned. An odometry
  /// with an augmented filter never calls it.
  virtual void correct_keyframes_by(KeyframeCorrector* /*corrector*/) {}

  [[nodiscard]] virtual std::uint64_t state_hash() const = 0;
};

}  // namespace rali::odometry
