#pragma once

#include <span>
#include <vector>

#include "rali/fleet/centre/joint_ranges.hpp"
#include "rali/fleet/centre/path_frames.hpp"
#include "rali/fleet/centre/path_submaps.hpp"
#include "rali/map/voxel_index.hpp"
#include "rali/places/grid_index.hpp"
#include "rali/ranging/settings.hpp"

namespace rali::fleet {

/// What the maps of all vehicles of a group have between two points: a vehicle alone knows its own
/// side of a wall, two know both (algorithms 4.3, step 3).
class SightLines {
 public:
  /// Pieces of paths of other groups are left out.
  SightLines(std::span<const PathSubmap> pieces, const PathFrames& frames, std::size_t group);

  /// Faces of walls, floors and furniture that the line goes through; both faces of one wall count.
  /// Those that it only grazes do not: a map that is off by centimetres would have them in the way.
  [[nodiscard]] int surfaces(const geometry::Vec3& p_map_m, const geometry::Vec3& q_map_m) const;

 private:
  [[nodiscard]] bool filled(const geometry::Vec3& p_map_m) const;

  std::vector<places::Plane> planes_;  ///< in the map
  places::GridIndex index_;            ///< of their middles
  map::VoxelIndex points_;             ///< a plane is believed only where points are: doors
};

/// Ranges through walls come late by decimetres that no other range of the pair contradicts: they
/// get the sigma of a blocked way (`sight.sigma_factor`), unless an end has doubted them as much.
void doubt_through_walls(std::span<const PathSubmap> pieces, const PathFrames& frames,
                         const ranging::RangingSettings& settings, JointRanges& joint);

}  // namespace rali::fleet
