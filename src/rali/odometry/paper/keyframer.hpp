#pragma once

#include <memory>

#include "rali/odometry/deskew.hpp"
#include "rali/odometry/odometry.hpp"
#include "rali/odometry/paper/octree.hpp"

namespace rali::odometry::paper {

/// Chooses keyframes by the overlap with the last one.
/// Source: paper, section "Keyframe Selection".
class OverlapKeyframer {
 public:
  OverlapKeyframer(double overlap_min, double radius_m, const geometry::SE3& T_body_lidar);

  /// Fraction of the `thinned` points of `cloud_lidar` (in the LiDAR frame at T_odom_body) with a
  /// point of the last keyframe within the radius; 0 if there is no keyframe yet, 1 without points.
  [[nodiscard]] double overlap(const BodyPoints& cloud_lidar,
                               std::span<const std::uint32_t> thinned,
                               const geometry::SE3& T_odom_body) const;

  [[nodiscard]] bool wants(double overlap) const { return !has_last_ || overlap < overlap_min_; }

  /// Whether the last keyframe is after_s old and the vehicle has moved since. In a degenerate
  /// stretch scans look alike and the overlap hardly drops, so corrections at keyframes would come
  /// late.
  [[nodiscard]] bool is_due(Time t, const geometry::SE3& T_odom_body, double after_s) const {
    constexpr double kMovedM = 0.1;  // standstill must not make keyframes
    return has_last_ && after_s > 0.0 && seconds_between(t_last_, t) >= after_s &&
           (T_odom_body.p - T_odom_body_last_.p).norm() > kMovedM;
  }

  /// Makes this scan the last keyframe.
  std::shared_ptr<const Keyframe> make(const sensor::LidarScan& scan, const BodyPoints& cloud_lidar,
                                       std::span<const std::uint32_t> thinned,
                                       const ScanResult& result);

  /// Corrects the pose of the last keyframe.
  void move_last(const geometry::SE3& T_odom_body) { T_odom_body_last_ = T_odom_body; }

  /// Forgets the last keyframe for the overlap; its pose stays the reference of the next one.
  void clear_overlap() { tree_.build({}, {}, {}); }

 private:
  double overlap_min_;
  double radius_m_;
  geometry::SE3 T_body_lidar_;
  Octree tree_;  ///< thinned points of the last keyframe in its LiDAR frame
  std::vector<float> x_m_, y_m_, z_m_;
  geometry::SE3 T_odom_body_last_;
  Time t_last_;
  bool has_last_ = false;
};

}  // namespace rali::odometry::paper
