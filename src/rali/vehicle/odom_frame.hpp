#pragma once

#include "rali/geometry/se3.hpp"
#include "rali/odometry/odometry.hpp"

namespace rali::vehicle {

/// The most that the LiDAR may move odom with one scan, beyond the predicted motion.
struct OdomLimits {
  double shift_m = 0.03;
  double turn_rad = 0.01;
  /// Without inertial data the prediction is constant velocity, and what the LiDAR finds beyond it
  /// is motion as far as the vehicle can accelerate: 3 cm in a tenth of a second, 0.75 m in half a
  /// second. A hand turns a sensor that fast.
  double accel_mps2 = 3.0;
  double accel_radps2 = 4.0;
  double scan_max_s = 0.5;  ///< of a longer time between two scans no more counts as motion
};

/// The frame `odom` of REP-105, in which a vehicle's pose never jumps: it goes by the predicted
/// motion, and follows what the LiDAR corrects in small steps. The filter's own frame, `local`,
/// moves at once, by ranges as well, and where a lost map begins again: what odom leaves out is in
/// T_map_odom. Output alone, nothing is estimated from it.
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
  geometry::SE3 T_lidar_body_;  ///< where the LiDAR alone would have it
};

/// Of the pose in odom: that of the pose in `local`, and what odom has left out.
[[nodiscard]] geometry::Mat6 odom_covariance(const geometry::Mat6& covariance_local,
                                             const geometry::SE3& T_local_body,
                                             const geometry::SE3& T_odom_body);

}  // namespace rali::vehicle
