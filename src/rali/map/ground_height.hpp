#pragma once

#include <optional>

#include "rali/map/keyframe_view.hpp"

namespace rali::map {

/// Height of the body's origin over the ground next to the vehicle [m]: the lowest height within
/// 5 m, map's z being up, that holds many points. Empty if nothing below the LiDAR looks like it.
[[nodiscard]] std::optional<double> ground_below_body(const KeyframeView& keyframe);

}  // namespace rali::map
