#pragma once

#include <optional>

#include "rali/geometry/types.hpp"
#include "rali/sensor/lidar_scan.hpp"

namespace rali::inspect {

/// Unit normal of the ground in the LiDAR frame, pointing from the ground to the LiDAR: the plane
/// with the most points near the vehicle among planes that lie below or above the LiDAR by its z
/// axis within 45 degrees. Empty if no plane holds a good part of the points.
[[nodiscard]] std::optional<geometry::Vec3> ground_normal(const sensor::LidarScan& scan);

}  // namespace rali::inspect
