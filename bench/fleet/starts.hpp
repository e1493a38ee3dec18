#pragma once

#include <cstdint>
#include <vector>

#include "rali/fleet/centre/knowledge.hpp"
#include "rali/geometry/se3.hpp"

namespace rali::fleet_bench {

/// Start poses of all but the first vehicle relative to it, as measured by tape and compass: errors
/// of 0.2 m, 3 deg, drawn from the seed. Upright.
/// @param T_world_start true body poses, by vehicle
[[nodiscard]] std::vector<fleet::GivenStart> starts_by_hand(
    const std::vector<geometry::SE3>& T_world_start, std::uint64_t seed);

}  // namespace rali::fleet_bench
