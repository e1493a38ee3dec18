#pragma once

#include "rali/geometry/se3.hpp"

namespace rali::odometry::paper {

/// Error of the submap: a scan is registered against the keyframes around it, and each of these
/// against those before it. One relative error per keyframe accumulates, as along a chain of poses;
/// a heading error displaces all later keyframes.
class MapError {
 public:
  /// A keyframe enters the submap. @param information of its registration, boxplus order. Along
  /// directions without information, the filter's covariance contains the keyframe's error.
  void add_keyframe(const geometry::SE3& T_odom_body, const geometry::Mat6& information);

  /// The keyframes were unconstrained along e_odom and accumulated this variance there.
  void add_along(const geometry::Vec3& e_odom, double variance_m2);

  /// Tracking was lost: the next keyframe starts a map at a guessed pose.
  void lose();

  /// The position along e_odom was measured from a landmark known to sigma_m, which replaces the
  /// map's error in that direction.
  void know_along(const geometry::Vec3& e_odom, double sigma_m);

  /// Covariance that the map's error adds to that of a pose, boxplus order.
  [[nodiscard]] geometry::Mat6 at(const geometry::SE3& T_odom_body) const;

 private:
  geometry::SE3 T_odom_keyframe_;
  geometry::Mat6 P_ = geometry::Mat6::Zero();  ///< at the keyframe
  bool started_ = false;
};

}  // namespace rali::odometry::paper
