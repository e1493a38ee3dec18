#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "rali/sensor/lidar_models.hpp"
#include "rali/sensor/lidar_scan.hpp"

namespace rali::wire::internal {

/// Where a ray from the origin leaves the box |x| < 9, |y| < 4, -1 < z < 2 [m], a room.
inline double room_range_m(double dx, double dy, double dz) {
  double range_m = 1e9;
  if (std::abs(dx) > 1e-9) range_m = std::min(range_m, 9.0 / std::abs(dx));
  if (std::abs(dy) > 1e-9) range_m = std::min(range_m, 4.0 / std::abs(dy));
  if (dz > 1e-9) range_m = std::min(range_m, 2.0 / dz);
  if (dz < -1e-9) range_m = std::min(range_m, 1.0 / -dz);
  return range_m;
}

/// One scan of a spinning sensor in that room, for tests: clockwise from the rear, column by
/// column, ring = index of the ascending elevation, the last column `period_s` (less one column)
/// after the first.
inline sensor::LidarScan room_scan(std::span<const float> elevations_deg, std::size_t columns,
                                   Time t_start, double period_s = 0.1) {
  sensor::LidarScan scan;
  for (std::size_t column = 0; column < columns; ++column) {
    const double fraction = static_cast<double>(column) / static_cast<double>(columns);
    const double azimuth = std::numbers::pi * (1.0 - 2.0 * fraction);
    for (std::size_t ring = 0; ring < elevations_deg.size(); ++ring) {
      const double elevation = static_cast<double>(elevations_deg[ring]) * std::numbers::pi / 180.0;
      const double dx = std::cos(elevation) * std::cos(azimuth);
      const double dy = std::cos(elevation) * std::sin(azimuth);
      const double dz = std::sin(elevation);
      const double range_m = room_range_m(dx, dy, dz);
      scan.push_back(static_cast<float>(dx * range_m), static_cast<float>(dy * range_m),
                     static_cast<float>(dz * range_m), static_cast<float>(ring),
                     static_cast<float>(fraction * period_s), static_cast<std::uint16_t>(ring));
    }
  }
  scan.t_start = t_start;
  scan.t_end = t_start + Duration::from_s(static_cast<double>(scan.dt_s.back()));
  scan.has_point_times = scan.has_rings = true;
  scan.rings = static_cast<std::uint16_t>(elevations_deg.size());
  return scan;
}

/// A VLP-16 in the room.
inline sensor::LidarScan vlp16_scan(Time t_start, std::size_t columns = 900,
                                    double period_s = 0.1) {
  return room_scan(sensor::find_lidar_model("vlp16")->elevations_deg, columns, t_start, period_s);
}

}  // namespace rali::wire::internal
