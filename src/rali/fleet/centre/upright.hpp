#pragma once

#include <optional>
#include <span>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/fleet/centre/path_submaps.hpp"

namespace rali::fleet {

/// Up direction in a path's odom from the observed surfaces: floors and ceilings across it, walls
/// along it. Nothing if the surfaces are not of that kind, or if z of odom would be off by more
/// than 40 degrees.
/// @param pieces of this path alone
[[nodiscard]] std::optional<geometry::Vec3> up_by_surfaces(std::span<const PathSubmap> pieces);

/// The paths with up determined from surfaces where inertial data did not determine it: a LiDAR
/// alone starts in an arbitrary attitude, a different one each time. Empty if no path needs it.
[[nodiscard]] std::vector<VehiclePath> upright(std::span<const VehiclePath> paths,
                                               const CutSettings& cut,
                                               const places::PlacesSettings& places,
                                               Executor& executor);

}  // namespace rali::fleet
