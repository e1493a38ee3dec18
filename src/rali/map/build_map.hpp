#pragma once

#include <optional>

#include "rali/base/executor.hpp"
#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"
#include "rali/map/keyframe_view.hpp"
#include "rali/map/map_cloud.hpp"
#include "rali/map/occupancy_grid.hpp"
#include "rali/map/plane_grid.hpp"
#include "rali/map/settings.hpp"

namespace rali::map {

struct MapResult {
  MapCloud map;
  MapCloud removed;  ///< people and vehicles
  std::optional<OccupancyGrid> grid;
  Thickness thickness;
  std::size_t keyframes = 0;
};

/// Renders the map of a run. Reads the keyframes twice if moving objects are removed, else once.
///
/// @return the map; what had to be left out is in `findings`. Errors: those of the stream;
///         kInput if it holds no keyframe.
[[nodiscard]] Result<MapResult> build_map(const KeyframeStream& keyframes,
                                          const MapSettings& settings, Executor& executor,
                                          FindingList& findings);

}  // namespace rali::map
