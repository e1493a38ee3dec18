#pragma once

#include <optional>

#include "rali/geometry/types.hpp"
#include "rali/sensor/lidar_scan.hpp"

namespace rali::inspect {

/// Unit normal, in the LiDAR frame, of the plane that may be the ground, pointing from it to the
/// LiDAR: the largest one within 45 degrees below the LiDAR by its z axis; without such a plane the
/// largest above, which is a ceiling unless the LiDAR hangs upside down. Empty if there is neither.
[[nodiscard]] std::optional<geometry::Vec3> ground_normal(const sensor::LidarScan& scan);

}  // namespace rali::inspect
