#pragma once

#include <string>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/drive/output/pose_files.hpp"

namespace rali::drive {

/// `odometry.degenerate`: stretches in which the LiDAR was blind along the way and no range held
/// the vehicle, so that its position rests on the inertial sensor and may be off by 0.3 m or more.
/// One for each tenth of the recording at most: what is said of all says nothing of where.
/// @param poses of the result, by time
[[nodiscard]] FindingList blind_findings(const std::vector<PoseRecord>& poses,
                                         const std::string& vehicle);

}  // namespace rali::drive
