#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "rali/drive/output/keyframe_files.hpp"
#include "rali/drive/output/pose_files.hpp"
#include "rali/vehicle/event.hpp"

namespace rali::drive {

/// The last correction of each keyframe by ranges, by keyframe number.
using KeyframeCorrections = std::map<std::uint32_t, vehicle::KeyframeCorrected>;

/// Moves keyframes to their corrected poses, and every other pose with them. The odometry's
/// relative pose to the previous keyframe is blended into that to the next keyframe. The weight is
/// the distance travelled between them (time at standstill, since a standing vehicle must not
/// creep). Before the first and after the last keyframe, the poses follow the only neighbour.
/// Covariances: between two corrected keyframes blended with the same weight; with only one
/// neighbour, its covariance plus the growth of the odometry's since; elsewhere unchanged. Diverged
/// keyframes are ignored. Without corrections nothing changes, to the last bit.
/// @param poses and keyframes by time, in odom
void correct_path(const KeyframeCorrections& corrections, std::vector<PoseRecord>& poses,
                  std::vector<KeyframeRecord>& keyframes);

}  // namespace rali::drive
