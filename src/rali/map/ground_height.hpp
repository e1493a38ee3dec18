#pragma once

#include <optional>

#include "rali/map/keyframe_view.hpp"

namespace rali::map {

/// Height of the body's origin over the ground next to the vehicle [m]: the lowest height within 5
/// m, map's z being up, that holds many points. Empty if no such height is below the LiDAR.
[[nodiscard]] std::optional<double> ground_below_body(const KeyframeView& keyframe);

}  // namespace rali::map
