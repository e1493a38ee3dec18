#pragma once

#include <optional>

#include "rali/base/finding.hpp"
#include "rali/base/time.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/odometry/deskew.hpp"

namespace rali::odometry {

/// Notices scans of something that covers the LiDAR: dust, spray, a curtain, a hand. Many of their
/// points lie in space that the scan before saw as free, all at once. A cover does not stand still
/// in the map, so such a scan says nothing about the pose, and its points are no part of the scene:
/// it is like a scan that never came. Who walks beside the vehicle hides less than half of it, and
/// comes gradually; a new room lies behind what was seen.
class CoverWatch {
 public:
  /// @param p_body_lidar origin of the rays
  explicit CoverWatch(const geometry::Vec3& p_body_lidar) : p_body_lidar_(p_body_lidar) {}

  /// A scan of the scene. @param T_odom_body its pose
  void show(const BodyPoints& points, const geometry::SE3& T_odom_body);

  /// @param T_odom_body predicted pose of the scan
  [[nodiscard]] bool covers(const BodyPoints& points, const geometry::SE3& T_odom_body) const;

  /// Each scan, in order. Reports a stretch of covered scans when it has ended.
  void note(bool covered, Time t_start, Time t_end, FindingList& findings);

  /// At the end of the data.
  void finish(FindingList& findings);

 private:
  struct Stretch {
    Time begin, last;
  };

  geometry::Vec3 p_body_lidar_;
  BodyPoints shown_;  ///< the last scan of the scene
  std::optional<geometry::SE3> T_odom_shown_;
  std::optional<Stretch> covered_;
};

}  // namespace rali::odometry
