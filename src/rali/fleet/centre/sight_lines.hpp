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

/// Surfaces between two points in the maps of all vehicles of a group: a single vehicle maps only
/// its own side of a wall, two map both (algorithms 4.3, step 3).
class SightLines {
 public:
  /// Pieces of paths of other groups are ignored.
  SightLines(std::span<const PathSubmap> pieces, const PathFrames& frames, std::size_t group);

  /// Number of faces of walls, floors and furniture on the line; both faces of one wall count.
  /// Faces at a grazing angle do not: a map error of centimetres would put them on the line.
  [[nodiscard]] int surfaces(const geometry::Vec3& p_map_m, const geometry::Vec3& q_map_m) const;

  /// ranging::leaves_seen_space() for the places of all vehicles.
  [[nodiscard]] bool leaves(const geometry::Vec3& p_map_m, const geometry::Vec3& q_map_m);

 private:
  [[nodiscard]] bool filled(const geometry::Vec3& p_map_m) const;

  std::vector<places::Plane> planes_;     ///< in the map
  places::GridIndex index_;               ///< of their middles
  map::VoxelIndex points_;                ///< a plane counts only where points are: doors
  std::vector<geometry::Vec3> places_m_;  ///< where the vehicles have been
  map::VoxelIndex tested_;                ///< cubes whose middle ranging::is_outside() has seen
  std::vector<bool> outside_;             ///< its results
};

/// Whether the frames that maps and ranges are compared in are known.
enum class FramesAre {
  kSupposed,  ///< in a wrong one lines end anywhere: no line then counts as leaving the space seen,
              ///< else no range could contradict it
  kFound
};

/// Ranges through walls or around a bend are too long by decimetres or metres, and no other range
/// of the pair contradicts them. They get the sigma of a blocked path (`sight.sigma_factor`),
/// unless an end has reported one as large.
void suspect_through_walls(std::span<const PathSubmap> pieces, const PathFrames& frames,
                           const ranging::RangingSettings& settings, FramesAre frames_are,
                           JointRanges& joint);

}  // namespace rali::fleet
