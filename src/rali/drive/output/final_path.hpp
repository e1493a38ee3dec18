#pragma once

#include <optional>
#include <vector>

#include "rali/drive/output/pose_files.hpp"

namespace rali::drive {

/// Where a vehicle was at any time of its run, by its final poses.
class FinalPath {
 public:
  /// @param poses in odom, by time; must outlive the object. Diverged ones are no place.
  FinalPath(const std::vector<PoseRecord>& poses, const geometry::SE3& T_map_local)
      : poses_(&poses), T_map_local_(T_map_local) {}

  /// T_map_body between the two sweeps around t, at constant speed. Nothing before the first and
  /// after the last sweep, where one of the two diverged, and in gaps above 1 s, unless it is known
  /// that the vehicle's path has none there.
  [[nodiscard]] std::optional<geometry::SE3> at(Time t) const;

  /// The last sweep up to t; null before the first.
  [[nodiscard]] const PoseRecord* before(Time t) const;

  /// T_map_body of the last good sweep up to t: where the vehicle was last known to be.
  [[nodiscard]] std::optional<geometry::SE3> last_known(Time t) const;

 private:
  const std::vector<PoseRecord>* poses_;
  geometry::SE3 T_map_local_;
};

}  // namespace rali::drive
