#pragma once

#include <memory>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/drive/reported_source.hpp"

namespace rali::drive {

/// Events of one vehicle from recordings (ROS 1 bag, rosbag2, MCAP), read one after the other as a
/// stream. Reads the first seconds to decide topics, cloud format, IMU units, stamps and
/// extrinsics; then returns everything from the start, ordered within 0.5 s. Memory does not grow
/// with the files.
/// Errors (kInput): no or several topics, raw packets, gravity removed, extrinsics that do not fit.
[[nodiscard]] Result<std::unique_ptr<ReportedSource>> open_recording_events(
    const std::vector<std::string>& paths, const InputOptions& options);

}  // namespace rali::drive
