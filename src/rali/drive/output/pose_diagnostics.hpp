#pragma once

#include <string>

#include "rali/drive/output/pose_files.hpp"
#include "rali/wire/messages.hpp"

namespace rali::drive {

/// `<vehicle>/degeneracy` of /diagnostics: observability of the directions by the LiDAR.
[[nodiscard]] wire::DiagnosticStatus degeneracy_status(const std::string& vehicle,
                                                       const PoseRecord& pose);

/// `<vehicle>/odometry`: how the pose of a scan was estimated.
[[nodiscard]] wire::DiagnosticStatus pose_status(const std::string& vehicle,
                                                 const PoseRecord& pose);

}  // namespace rali::drive
