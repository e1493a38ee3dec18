#pragma once

#include <deque>
#include <optional>

#include "rali/base/time.hpp"
#include "rali/geometry/se3.hpp"

namespace rali::odometry {

/// Acceleration that the poses imply: the change between the mean velocities of two seconds in a
/// row. Single scans are too noisy for it, and steps of the body shorter than a second are none.
class AccelerationWatch {
 public:
  /// Once for each scan. @param step  motion of the body since the last scan, in the body then
  void add(Time t, const geometry::SE3& step);

  /// The chain of steps is broken: a new map, a standstill.
  void reset() { path_.clear(); }

  /// [m/s2]; nothing before two seconds are full, or where scans are missing.
  [[nodiscard]] std::optional<double> mean_mps2() const;

 private:
  struct Point {
    Time t;
    geometry::Vec3 p;
  };

  geometry::SE3 T_;         ///< of the newest step
  std::deque<Point> path_;  ///< of the last two seconds and a little more
};

/// Of a correction of the position by the LiDAR, the part that the uncertainty of the prediction
/// does not explain: that part is a motion, the other one an error made good.
/// @param covariance_m2  of the predicted position, in the frame of the correction
[[nodiscard]] geometry::Vec3 unexplained_shift(const geometry::Vec3& shift_m,
                                               const geometry::Mat3& covariance_m2);

}  // namespace rali::odometry
