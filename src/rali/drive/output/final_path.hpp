#pragma once

#include <optional>
#include <vector>

#include "rali/drive/output/pose_files.hpp"

namespace rali::drive {

/// A vehicle's pose at any time of its run, from its final poses.
class FinalPath {
 public:
  /// @param poses in odom, by time; must outlive the object. Diverged ones are not used.
  FinalPath(const std::vector<PoseRecord>& poses, const geometry::SE3& T_map_local)
      : poses_(&poses), T_map_local_(T_map_local) {}

  /// T_map_body interpolated between the two scans around t, at constant speed. Empty before the
  /// first and after the last scan, where one of the two diverged, and in gaps above 1 s, unless
  /// the path is known to be continuous there.
  [[nodiscard]] std::optional<geometry::SE3> at(Time t) const;

  /// The last scan up to t; null before the first.
  [[nodiscard]] const PoseRecord* before(Time t) const;

  /// T_map_body of the last good scan up to t: the last known pose of the vehicle.
  [[nodiscard]] std::optional<geometry::SE3> last_known(Time t) const;

 private:
  const std::vector<PoseRecord>* poses_;
  geometry::SE3 T_map_local_;
};

}  // namespace rali::drive
