#pragma once

#include "rali/geometry/se3.hpp"

namespace rali::odometry::paper {

/// How far the submap may be off: a scan is known against the keyframes around it, and each of
/// these was registered against those before it. One relative error per keyframe adds up, the way
/// poses do along a chain; an error of heading moves all that comes after.
class MapError {
 public:
  /// A keyframe enters the submap. @param information of its registration, boxplus order; where it
  /// has none the filter knows what the keyframe may be off by.
  void add_keyframe(const geometry::SE3& T_odom_body, const geometry::Mat6& information);

  /// Nothing held the keyframes along e_odom, and this variance came together there.
  void add_along(const geometry::Vec3& e_odom, double variance_m2);

  /// The track was lost: the next keyframe begins a map that hangs on a guess.
  void lose();

  /// The position along e_odom was measured from a place known to sigma_m: what is wrong with the
  /// map there is put right, but for that.
  void know_along(const geometry::Vec3& e_odom, double sigma_m);

  /// Covariance that the map's error adds to that of a pose, boxplus order.
  [[nodiscard]] geometry::Mat6 at(const geometry::SE3& T_odom_body) const;

 private:
  geometry::SE3 T_odom_keyframe_;
  geometry::Mat6 P_ = geometry::Mat6::Zero();  ///< at the keyframe
  bool started_ = false;
};

}  // namespace rali::odometry::paper
