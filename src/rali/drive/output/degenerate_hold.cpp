#include "rali/drive/output/degenerate_hold.hpp"

namespace rali::drive {
namespace {

constexpr double kRange_s = 2.0;
constexpr double kImu_s = 3.0;

}  // namespace

HeldBy DegenerateHold::see(const vehicle::PoseEstimate& pose, bool has_imu) {
  if (pose.range_from) t_range_ = pose.t;
  if (pose.quality == vehicle::PoseQuality::kDiverged) return HeldBy::kNothing;
  if (!pose.degeneracy.degenerate) {
    t_held_ = pose.t;
    return HeldBy::kLidar;
  }
  if (t_range_ && seconds_between(*t_range_, pose.t) <= kRange_s) {
    t_held_ = pose.t;
    return HeldBy::kRange;
  }
  if (pose.at_rest) {
    t_held_ = pose.t;
    return HeldBy::kImu;
  }
  const bool lately = t_held_ && seconds_between(*t_held_, pose.t) <= kImu_s;
  return has_imu && lately ? HeldBy::kImu : HeldBy::kNothing;
}

}  // namespace rali::drive
