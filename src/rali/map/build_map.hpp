#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"
#include "rali/map/keyframe_view.hpp"
#include "rali/map/map_cloud.hpp"
#include "rali/map/motion_filter.hpp"
#include "rali/map/occupancy_grid.hpp"
#include "rali/map/plane_grid.hpp"
#include "rali/map/settings.hpp"

namespace rali::map {

/// Agreement of one keyframe with the walls of the whole map.
struct KeyframeLooks {
  std::uint8_t vehicle = 0;
  Time t;
  WallLooks walls;
  WallsMade made;
};

struct MapResult {
  MapCloud map;
  MapCloud removed;  ///< people and vehicles
  std::optional<CellMap> grid;
  Thickness thickness;
  std::size_t keyframes = 0;
  std::vector<KeyframeLooks> looks;  ///< in the order of the stream
};

/// Compares each keyframe with the walls seen by all keyframes, without making a map.
[[nodiscard]] Result<std::vector<KeyframeLooks>> look_at_walls(const KeyframeStream& keyframes,
                                                               const DynamicSettings& settings,
                                                               Executor& executor);

/// Renders the map of a run. Reads the keyframes twice.
///
/// @return the map; what was left out is in `findings`. Errors: those of the stream; kInput if it
/// holds no keyframe.
[[nodiscard]] Result<MapResult> build_map(const KeyframeStream& keyframes,
                                          const MapSettings& settings, Executor& executor,
                                          FindingList& findings);

}  // namespace rali::map
