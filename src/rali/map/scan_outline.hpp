#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "rali/map/ground_height.hpp"
#include "rali/map/keyframe_view.hpp"

namespace rali::map {

/// What of a scan is ground, obstacle and free space.
struct OutlineSettings {
  double cell_m = 0.2;
  double range_m = 20.0;             ///< obstacles and free space up to here
  double low_m = 0.2, high_m = 1.2;  ///< the band of obstacles above the local ground
  double slope_max_deg = 20.0;       ///< steeper is an obstacle, but for what the vehicle stands on
  double step_m = 0.15;              ///< higher steps are obstacles
  double drop_m = 0.3;               ///< deeper drops are obstacles, ...
  double drop_range_m = 5.0;         ///< ... if seen from nearer than this
};

/// Free space and obstacles of one keyframe, flattened once: independent of its pose, so that a
/// correction of the pose only inserts it again.
///
/// Frame `level`: origin and heading of the body, z up.
struct ScanOutline {
  static constexpr std::size_t kSectors = 720;  ///< half a degree: 0.17 m at 20 m

  geometry::Vec2 sensor_level_m = geometry::Vec2::Zero();
  std::vector<float> hit_x_m, hit_y_m;  ///< obstacles in level, at most one per cell
  /// Free up to here, per sector of level around the sensor, first sector at -pi; 0: unknown.
  std::array<float, kSectors> free_m{};
  /// Free from here on: nearer, all rays are above the band or below it. Empty: from the sensor on.
  std::vector<float> from_m;
};

/// Heading of a pose; the remaining rotation is tilt.
[[nodiscard]] double yaw_of(const geometry::SE3& T_map_body);

/// Flattens a keyframe (algorithms_fleet 9.5). The ground is grown outward from under the vehicle,
/// sector by sector, while its slope stays below slope_max_deg (or is that of the ground under the
/// vehicle, which has driven there); this bridges the gaps between rings. Obstacles are points of
/// the band above that ground, steps and near drops. Every ray with a return clears the cells along
/// it while it is inside the band; the nearest obstacle of a sector ends its free space. Gaps
/// between rays are clear up to where an object wider than two cells would fit between them. Points
/// that are not finite are left out.
[[nodiscard]] ScanOutline outline_of(const KeyframeView& keyframe, const Ground& ground,
                                     const OutlineSettings& settings);

}  // namespace rali::map
