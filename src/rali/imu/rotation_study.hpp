#pragma once

#include <optional>
#include <span>
#include <vector>

#include "rali/base/time.hpp"
#include "rali/geometry/so3.hpp"
#include "rali/sensor/imu_sample.hpp"

namespace rali::imu {

/// Rotation of the LiDAR between two instants of its own clock, from LiDAR odometry.
struct LidarTurn {
  Time begin, end;
  geometry::Vec3 turn_lidar_rad = geometry::Vec3::Zero();  ///< Log(R_begin' R_end), LiDAR frame
};

/// Orientation of the IMU over time, integrated from the gyro alone. Differences over tenths of a
/// second are accurate although the integral drifts over minutes.
class GyroTrack {
 public:
  /// @param scale converts the rates of the samples to rad/s
  explicit GyroTrack(std::span<const sensor::ImuSample> samples, double scale = 1.0);

  /// Log(R(begin)' R(end)) in the IMU frame; empty outside the data or across a gap of 0.1 s.
  [[nodiscard]] std::optional<geometry::Vec3> turn(Time begin, Time end) const;

 private:
  struct Knot {
    Time t;
    geometry::Mat3 R;
    geometry::Vec3 rate_radps;  ///< mean until the next knot
    int gaps_before = 0;
  };

  [[nodiscard]] const Knot* knot_before(Time t) const;
  [[nodiscard]] static geometry::Mat3 orientation(const Knot& knot, Time t);

  std::vector<Knot> knots_;
};

/// How well IMU and LiDAR rotations agree under one rotation R_imu_lidar.
struct RotationFit {
  geometry::Mat3 R_imu_lidar = geometry::Mat3::Identity();
  double misfit = 0.0;  ///< rms of the residual / rms of the rotations; roughly an angle in rad
};

/// What the rotation rates of both sensors reveal about their units, time offset and mounting.
struct RotationStudy {
  std::size_t pairs = 0;
  double turned_rad = 0.0;     ///< sum of the LiDAR's rotations
  double turn_rate_rms = 0.0;  ///< of the LiDAR, its noise included [rad/s]
  double gyro_rate_rms = 0.0;  ///< of the gyro's slow rotations, without their mean [rad/s]
  double gyro_ratio = 0.0;     ///< gyro / LiDAR in slow rotations; 57.3: deg/s. 0: not observable
  /// The same if all differences were noise of the gyro. gyro_ratio has all of them as noise of the
  /// LiDAR: the true ratio is between the two (Frisch 1934).
  double gyro_ratio_max = 0.0;
  /// Fraction of the rotation about the second axis (0..1): near 0, the vehicle turned about one
  /// axis only and the mounting rotation about it is not observable.
  double second_axis_fraction = 0.0;
  RotationFit best;                     ///< the rotation that fits best
  std::optional<double> time_offset_s;  ///< to be added to LiDAR stamps
  double time_offset_sigma_s = 0.0;     ///< its 1-sigma, also if no offset is given
  bool offset_at_border = false;
};

struct RotationStudyLimits {
  double offset_max_s = 0.3;
  double offset_step_s = 0.005;
  double offset_sigma_max_s = 0.01;  ///< a less certain offset is not given
  double turned_min_rad = 0.5;       ///< with less rotation there is no result
  std::size_t pairs_min = 10;
  double slow_s = 1.0;  ///< offset and ratio are estimated from motion slower than this
};

/// Estimates gyro unit, time offset and mounting rotation from the rotations of both sensors.
///
/// A scan averages the shaking of a vehicle over its points. The instant of that average depends on
/// where the walls are: up to 30 ms of apparent delay. Offset and unit are therefore estimated from
/// slow rotations of both sensors, over slow_s and averaged over slow_s. The mounting rotation uses
/// all rotations, since shaking is often the only rotation about a second axis.
///
/// With phi_I the gyro's rotation over the LiDAR's interval shifted by the offset d, the model is
/// phi_I = R phi_L + b dt. For each d on a grid, the mean removes b and Kabsch's solution gives R.
/// The sum of squares S(d) is minimal at the offset; a parabola refines it below the grid step. Its
/// variance is 2 s^2 / S'' with s^2 the variance of one component. The search is done for a gyro in
/// rad/s and for one in deg/s, since rotations 57 times too large wrap around.
///
/// Rates alone cannot reveal a mirrored frame: they are pseudo-vectors, and mirroring y looks like
/// half a turn about y. Compare R with the ground's normal to detect it.
[[nodiscard]] RotationStudy study_rotations(std::span<const LidarTurn> lidar,
                                            std::span<const sensor::ImuSample> imu,
                                            const RotationStudyLimits& limits = {});

/// Misfit of a given rotation, with the study's time offset (or none) and ratio applied.
[[nodiscard]] double misfit_of(const geometry::Mat3& R_imu_lidar, std::span<const LidarTurn> lidar,
                               std::span<const sensor::ImuSample> imu, const RotationStudy& study);

}  // namespace rali::imu
