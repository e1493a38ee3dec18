#pragma once

#include <string>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/drive/output/pose_files.hpp"

namespace rali::drive {

/// `odometry.degenerate`: stretches in which the LiDAR was degenerate along the path and no range
/// constrained the vehicle. Its position there depends on the inertial sensor and may be off by 0.3
/// m or more. Each covers at most a tenth of the recording: a longer one would not localise the
/// problem.
/// @param poses of the result, by time
[[nodiscard]] FindingList degenerate_findings(const std::vector<PoseRecord>& poses,
                                              const std::string& vehicle);

}  // namespace rali::drive
