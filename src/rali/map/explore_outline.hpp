#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "rali/map/explore_settings.hpp"
#include "rali/map/keyframe_view.hpp"

namespace rali::map {

/// What one keyframe says about free space, flattened once: independent of where it lies, so that
/// a corrected pose only places it anew.
///
/// Frame `level`: origin and heading of the body, z up.
struct ScanOutline {
  static constexpr std::size_t kSectors = 720;  ///< half a degree: 0.17 m at 20 m

  geometry::Vec2 sensor_level_m = geometry::Vec2::Zero();
  std::vector<float> hit_x_m, hit_y_m;  ///< obstacles in level, at most one per cell
  /// Per sector of level around the sensor, first sector at -pi: free up to here; 0: not known.
  std::array<float, kSectors> free_m{};
};

/// Heading of a pose: the rest of its attitude is tilt.
[[nodiscard]] double yaw_of(const geometry::SE3& T_map_body);

/// Flattens a keyframe (algorithms_fleet 9.5): the ground is grown outward from under the vehicle,
/// sector by sector, as long as it rises and falls less than slope_max_deg, which bridges the gaps
/// between rings; obstacles are points of the band above that ground, steps and near drops. Every
/// ray that came back clears its way as far as it is inside the band; in a sector the nearest
/// obstacle ends what is clear. Gaps between rays are clear as far as nothing wider than two cells
/// fits between them.
/// `below_m`: height of the body over the ground. Points that are not numbers are left out.
[[nodiscard]] ScanOutline outline_of(const KeyframeView& keyframe, double below_m,
                                     const ExploreSettings& settings);

}  // namespace rali::map
