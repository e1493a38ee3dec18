#pragma once

#include <optional>

#include "rali/geometry/types.hpp"
#include "rali/sensor/lidar_scan.hpp"

namespace rali::inspect {

/// Unit normal, in the LiDAR frame, of the probable ground plane, pointing from it to the LiDAR. It
/// is the largest plane within 45 degrees below the LiDAR by its z axis. Without such a plane it is
/// the largest above, a ceiling unless the LiDAR is upside down. Empty if there is neither.
[[nodiscard]] std::optional<geometry::Vec3> ground_normal(const sensor::LidarScan& scan);

}  // namespace rali::inspect
