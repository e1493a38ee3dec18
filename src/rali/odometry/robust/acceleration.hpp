#pragma once

#include <deque>
#include <optional>

#include "rali/base/time.hpp"
#include "rali/geometry/se3.hpp"

namespace rali::odometry {

/// Acceleration implied by the poses: the change between the mean velocities of two consecutive
/// seconds. Single scans are too noisy for it; steps of the body shorter than a second are ignored.
class AccelerationWatch {
 public:
  /// Call once for each scan. @param step motion of the body since the last scan, in the earlier
  /// body
  void add(Time t, const geometry::SE3& step);

  /// Call when the chain of steps breaks: a new map, a standstill.
  void reset() { path_.clear(); }

  /// [m/s2]; nothing during the first two seconds, or if scans are missing.
  [[nodiscard]] std::optional<double> mean_mps2() const;

 private:
  struct Point {
    Time t;
    geometry::Vec3 p;
  };

  geometry::SE3 T_;         ///< of the newest step
  std::deque<Point> path_;  ///< of the last two seconds and slightly more
};

/// The part of a LiDAR position correction that the uncertainty of the prediction does not explain.
/// This part is motion, the rest corrects an error.
/// @param covariance_m2  of the predicted position, in the frame of the correction
[[nodiscard]] geometry::Vec3 unexplained_shift(const geometry::Vec3& shift_m,
                                               const geometry::Mat3& covariance_m2);

}  // namespace rali::odometry
