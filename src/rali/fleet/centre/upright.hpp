#pragma once

#include <optional>
#include <span>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/fleet/centre/path_submaps.hpp"

namespace rali::fleet {

/// Up in a path's odom by what it saw: floors and ceilings across it, walls along it. Nothing if
/// its surfaces are not of that kind, or say that z of odom was off by more than 40 degrees.
/// @param pieces of this path alone
[[nodiscard]] std::optional<geometry::Vec3> up_by_surfaces(std::span<const PathSubmap> pieces);

/// The paths with up found by surfaces where no inertial data told it: a LiDAR alone begins in
/// whatever attitude it was held, another one each time. Empty if there is none to mend.
[[nodiscard]] std::vector<VehiclePath> upright(std::span<const VehiclePath> paths,
                                               const CutSettings& cut,
                                               const places::PlacesSettings& places,
                                               Executor& executor);

}  // namespace rali::fleet
