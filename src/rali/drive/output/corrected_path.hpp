#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "rali/drive/output/keyframe_files.hpp"
#include "rali/drive/output/pose_files.hpp"
#include "rali/vehicle/event.hpp"

namespace rali::drive {

/// What was last said of each keyframe that ranges corrected, by its running number.
using KeyframeCorrections = std::map<std::uint32_t, vehicle::KeyframeCorrected>;

/// Moves keyframes to where they were last said to be, and every pose with them. A pose keeps its
/// place relative to the keyframe before it as the odometry told it; towards the next keyframe it
/// passes over to its place relative to that one, in proportion to the way driven (by time where
/// the vehicle stood: standing, it must not creep). Before the first and after the last keyframe
/// there is only one to follow.
/// Covariances: between two corrected keyframes mixed in the same proportion; where there is only
/// one, its own and what the odometry's has grown by since; elsewhere as told. Diverged keyframes
/// carry nothing. Without corrections nothing changes, to the last bit.
/// @param poses and keyframes by time, in odom
void correct_path(const KeyframeCorrections& corrections, std::vector<PoseRecord>& poses,
                  std::vector<KeyframeRecord>& keyframes);

}  // namespace rali::drive
