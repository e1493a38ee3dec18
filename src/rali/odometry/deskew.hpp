#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "rali/base/time.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/sensor/lidar_scan.hpp"

namespace rali::odometry {

/// Flat points in the body frame at the end of a scan, with the time of each measurement.
struct BodyPoints {
  std::vector<float> x_m, y_m, z_m;
  std::vector<float> age_s;  ///< t_end - time of the point, >= 0

  [[nodiscard]] std::size_t size() const { return x_m.size(); }

  void clear();
  void resize(std::size_t n);
};

/// One pose of the body during a scan.
struct TimedPose {
  Time t;
  geometry::SE3 T_odom_body;
};

/// Motion of the LiDAR within a scan, as a table of transforms to the body at its end. Matrices are
/// interpolated linearly between entries (at 2.5 ms and 3 rad/s the rotation error is below 1e-5
/// rad).
class ScanMotion {
 public:
  /// @param poses ascending in time; the last is at the end of the scan and defines the target.
  ///         Before the first, motion is extrapolated at the rate of the first two poses.
  ScanMotion(std::span<const TimedPose> poses, Time t_start, const geometry::SE3& T_body_lidar);

  /// A scan without motion: every point is transformed by T_body_lidar alone.
  explicit ScanMotion(const geometry::SE3& T_body_lidar);

  /// Body coordinates at the end of the scan of the points `indices` of `scan` (all if empty).
  void apply(const sensor::LidarScan& scan, std::span<const std::uint32_t> indices,
             BodyPoints& out) const;

 private:
  using Matrix34f = Eigen::Matrix<float, 3, 4>;

  std::vector<Matrix34f> T_end_lidar_;  ///< at t_start + k * step
  float step_inverse_ = 0.0F;
  Time t_start_;
};

}  // namespace rali::odometry
