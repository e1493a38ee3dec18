#pragma once

#include "rali/geometry/se3.hpp"
#include "rali/odometry/odometry.hpp"

namespace rali::vehicle {

/// The largest correction of odom by the LiDAR in one scan, beyond the predicted motion.
struct OdomLimits {
  double shift_m = 0.03;
  double turn_rad = 0.01;
  /// Without inertial data the prediction is constant velocity. A correction by the LiDAR then
  /// counts as motion up to what the vehicle can accelerate: 3 cm in a tenth of a second, 0.75 m in
  /// half a second. A hand turns a sensor that fast.
  double accel_mps2 = 3.0;
  double accel_radps2 = 4.0;
  double scan_max_s = 0.5;  ///< a longer time between two scans counts as this
};

/// The frame `odom` of REP-105, in which the pose of a vehicle never jumps. It follows the
/// predicted motion, and takes corrections by the LiDAR in small steps. In the filter's own frame,
/// `local`, the pose shifts at once, also by ranges and where a lost map starts again. T_map_odom
/// contains the corrections that odom omits. It is output only: nothing is estimated from it.
class OdomFrame {
 public:
  explicit OdomFrame(const OdomLimits& limits = {}) : limits_(limits) {}

  /// Call for every scan with a pose. @return T_odom_body
  geometry::SE3 follow(const odometry::ScanResult& result);

 private:
  [[nodiscard]] OdomLimits limits_for(const odometry::ScanResult& result) const;

  OdomLimits limits_;
  bool started_ = false;
  Time t_;  ///< of the last scan
  geometry::SE3 T_odom_body_;
  geometry::SE3 T_lidar_body_;  ///< with all corrections by the LiDAR, unlimited
};

/// Covariance of the pose in odom: that of the pose in `local`, plus the square of what odom omits.
[[nodiscard]] geometry::Mat6 odom_covariance(const geometry::Mat6& covariance_local,
                                             const geometry::SE3& T_local_body,
                                             const geometry::SE3& T_odom_body);

}  // namespace rali::vehicle
