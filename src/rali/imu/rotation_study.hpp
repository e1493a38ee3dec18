#pragma once

#include <optional>
#include <span>
#include <vector>

#include "rali/base/time.hpp"
#include "rali/geometry/so3.hpp"
#include "rali/sensor/imu_sample.hpp"

namespace rali::imu {

/// Turn of the LiDAR between two instants of its own clock, as LiDAR odometry saw it.
struct LidarTurn {
  Time begin, end;
  geometry::Vec3 turn_lidar_rad = geometry::Vec3::Zero();  ///< Log(R_begin' R_end), LiDAR frame
};

/// Orientation of the IMU over time, integrated from the gyro alone: differences over tenths of a
/// second are exact where the sum over minutes drifts.
class GyroTrack {
 public:
  /// @param scale makes rad/s of the samples' rates
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
  double misfit = 0.0;  ///< rms of what is left / rms of the turning; about an angle in rad
};

/// What rotation rates tell about the pair of sensors.
struct RotationStudy {
  std::size_t pairs = 0;
  double turned_rad = 0.0;     ///< sum of the LiDAR's turns
  double turn_rate_rms = 0.0;  ///< rad/s
  double gyro_ratio = 0.0;     ///< gyro / LiDAR of slow turns; 57.3: deg/s. 0: not observable
  /// Share of turning about the second axis (0..1): near 0, the vehicle turned about one axis
  /// only and the rotation about it is not observable.
  double second_axis_share = 0.0;
  RotationFit best;                     ///< the rotation that fits best
  std::optional<double> time_offset_s;  ///< to be added to LiDAR stamps
  double time_offset_sigma_s = 0.0;     ///< its 1-sigma, also where the offset is not given
  bool offset_at_border = false;
};

struct RotationStudyLimits {
  double offset_max_s = 0.3;
  double offset_step_s = 0.005;
  double offset_sigma_max_s = 0.01;  ///< a less certain offset is not given
  double turned_min_rad = 0.5;       ///< less turning tells nothing
  std::size_t pairs_min = 10;
  double slow_s = 1.0;  ///< offset and ratio come from motion slower than this
};

/// Finds gyro unit, time offset and rotation from the turns both sensors saw.
///
/// A sweep sees the shaking of a vehicle only as a mean over its points, at an instant that depends
/// on where the walls are: up to 30 ms of apparent delay. Offset and unit are therefore found from
/// slow turns, over slow_s and averaged over slow_s, of both sensors; the rotation from all turns,
/// since the shaking is often the only turning about a second axis.
///
/// With phi_I the gyro's turn over the LiDAR's interval shifted by the offset d, the model is
/// phi_I = R phi_L + b dt. For each d on a grid, b is taken out by the mean and R by Kabsch's
/// solution; the sum of squares S(d) has its minimum at the offset, found below the step by a
/// parabola. Its variance is 2 s^2 / S'' with s^2 the variance of one component. The search is
/// done for a gyro in rad/s and for one in deg/s, since turns of 57 times the truth wrap around.
///
/// Rates alone cannot tell a mirrored frame: they are pseudo-vectors, and mirroring y looks like
/// half a turn about y. Compare R with the ground's normal for that.
[[nodiscard]] RotationStudy study_rotations(std::span<const LidarTurn> lidar,
                                            std::span<const sensor::ImuSample> imu,
                                            const RotationStudyLimits& limits = {});

/// Misfit of a given rotation, with the study's time offset (or none) and ratio applied.
[[nodiscard]] double misfit_of(const geometry::Mat3& R_imu_lidar, std::span<const LidarTurn> lidar,
                               std::span<const sensor::ImuSample> imu, const RotationStudy& study);

}  // namespace rali::imu
