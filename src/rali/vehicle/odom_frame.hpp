#pragma once

#include "rali/geometry/se3.hpp"
#include "rali/odometry/odometry.hpp"

namespace rali::vehicle {

/// The most that the LiDAR may move odom with one scan, beyond the predicted motion.
struct OdomLimits {
  double shift_m = 0.03;
  double turn_rad = 0.01;
};

/// The frame `odom` of REP-105, in which a vehicle's pose never jumps: it goes by the predicted
/// motion, and follows what the LiDAR corrects in small steps. The filter's own frame, `local`,
/// moves at once, and by ranges as well: what odom leaves out is in T_map_odom. Output alone,
/// nothing is estimated from it.
class OdomFrame {
 public:
  explicit OdomFrame(const OdomLimits& limits = {}) : limits_(limits) {}

  /// To be told of every scan with a pose. @return T_odom_body
  geometry::SE3 follow(const odometry::ScanResult& result);

 private:
  OdomLimits limits_;
  bool started_ = false;
  geometry::SE3 T_odom_body_;
  geometry::SE3 T_lidar_body_;  ///< where the LiDAR alone would have it
};

/// Of the pose in odom: that of the pose in `local`, and what odom has left out.
[[nodiscard]] geometry::Mat6 odom_covariance(const geometry::Mat6& covariance_local,
                                             const geometry::SE3& T_local_body,
                                             const geometry::SE3& T_odom_body);

}  // namespace rali::vehicle
