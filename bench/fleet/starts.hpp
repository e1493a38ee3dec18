#pragma once

#include <cstdint>
#include <vector>

#include "rali/fleet/centre/knowledge.hpp"
#include "rali/geometry/se3.hpp"

namespace rali::fleet_bench {

/// Start poses of all but the first relative to it, as somebody with a tape and a compass measures
/// them: 0.2 m, 3 deg, drawn from the seed. Upright.
/// @param T_world_start truth of the bodies, by vehicle
[[nodiscard]] std::vector<fleet::GivenStart> starts_by_hand(
    const std::vector<geometry::SE3>& T_world_start, std::uint64_t seed);

}  // namespace rali::fleet_bench
