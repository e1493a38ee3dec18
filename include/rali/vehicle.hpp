#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "rali/error.hpp"
#include "rali/events.hpp"
#include "rali/types.hpp"

namespace rali {

/// How the LiDAR constrains one scan's pose.
struct Degeneracy {
  bool degenerate = false;             ///< a direction of translation is not observable
  Vec3 direction_odom = Vec3::Zero();  ///< unit, the least observable one; zero: none
  double sigma_m = 0.0;                ///< of this scan's position along it; infinity: no
                                       ///< information
  /// Along the least observable horizontal direction, across it, up; infinity as above.
  std::array<double, 3> translation_sigma_m{};
  double degree = std::numeric_limits<double>::quiet_NaN();  ///< lambda2/lambda3 of the normals
};

/// What constrains the pose of one scan.
enum class PoseQuality { kGood, kWeak, kPredicted, kDiverged };

/// The pose at the last point of one scan, as estimated when the scan was processed.
struct PoseEstimate {
  std::string vehicle;
  std::int64_t stamp_ns = 0;
  Pose3 T_odom_body = Pose3::Identity();   ///< frame `odom` never jumps
  Pose3 T_local_body = Pose3::Identity();  ///< frame `local` applies corrections at once
  Vec3 v_odom_mps = Vec3::Zero();
  Covariance6 covariance = Covariance6::Zero();        ///< of T_odom_body
  Covariance6 covariance_local = Covariance6::Zero();  ///< of T_local_body
  PoseQuality quality = PoseQuality::kGood;
  Degeneracy degeneracy;
  int correspondences = 0;  ///< points matched to a plane
  bool standstill = false;
  double range_correction_m = 0.0;  ///< by ranges, since the previous scan

  [[nodiscard]] double t_s() const { return seconds(stamp_ns); }
};

/// A scan kept for the map: undistorted points in body at its time.
struct Keyframe {
  std::string vehicle;
  std::uint32_t index = 0;  ///< from 0
  std::int64_t stamp_ns = 0;
  Pose3 T_local_body = Pose3::Identity();
  std::vector<float> x_m, y_m, z_m, intensity;
};

/// How one range was used.
struct RangeResult {
  RangeMeasurement measurement;
  bool used = false;
  std::string reason;  ///< used, nlos, outlier, out_of_limits, no_pose, ...: as in ranges.csv
  double predicted_m = std::numeric_limits<double>::quiet_NaN();  ///< NaN: unknown
  double residual_m = std::numeric_limits<double>::quiet_NaN();   ///< measured minus predicted
  double sigma_m = std::numeric_limits<double>::quiet_NaN();      ///< of the residual, as predicted
};

using Output = std::variant<PoseEstimate, Keyframe, RangeResult, RunFinding>;

/// White noise and bias random walk of an IMU, as data sheets state them.
struct ImuNoise {
  double accel_mps2_rthz = 1e-2, gyro_radps_rthz = 1e-3;
  double accel_walk_mps3_rthz = 1e-4, gyro_walk_radps2_rthz = 1e-5;
  double vibration_factor = 3.0;  ///< white noise while driving / data sheet value
};

/// Another vehicle, or a beacon, to which ranges are measured.
struct Peer {
  std::string name;
  std::vector<Vec3> antennas_body_m = {Vec3::Zero()};
};

/// The effective values of all settings of docs/reference/settings.md that concern one vehicle: the
/// defaults unless changed by with_settings() or a recording's fleet.yaml.
class VehicleSettings {
 public:
  struct Impl;
  VehicleSettings();
  explicit VehicleSettings(std::shared_ptr<const Impl> impl);  ///< internal: used by the library
                                                               ///< only

  /// Internal: used by the library only.
  [[nodiscard]] const Impl& impl() const { return *impl_; }

 private:
  std::shared_ptr<const Impl> impl_;
};

/// What a Vehicle needs before its first event.
struct VehicleOptions {
  std::string name = "v1";
  Pose3 T_body_lidar = Pose3::Identity();
  Pose3 T_body_imu = Pose3::Identity();
  bool has_imu = true;  ///< false: LiDAR alone
  ImuNoise imu_noise;
  std::array<double, 2> range_m = {0.4, 100.0};  ///< points nearer or farther are left out
  std::vector<Vec3> antennas_body_m = {Vec3::Zero()};
  std::vector<Peer> peers;
  VehicleSettings settings;
};

/// One vehicle's odometry, stepped by the caller: a pure function of its events, without clock,
/// thread or file. Same options and events: same outputs, byte for byte. Not thread-safe.
class Vehicle {
 public:
  /// Throws SettingsError: two peers of one name, a peer named as the vehicle, no antenna.
  explicit Vehicle(const VehicleOptions& options);
  ~Vehicle();
  Vehicle(Vehicle&&) noexcept;
  Vehicle& operator=(Vehicle&&) noexcept;

  /// Processes one event and returns the outputs. A scan waits for inertial data up to its last
  /// point, so its pose is returned with a later event. Unusable data are rejected with a
  /// RunFinding. Throws InputError: scan arrays of different length, a range or state of a vehicle
  /// that is no peer.
  [[nodiscard]] std::vector<Output> step(Event event);

  /// Hash of the whole state, to find the first event at which two runs differ.
  [[nodiscard]] std::uint64_t state_hash() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rali
