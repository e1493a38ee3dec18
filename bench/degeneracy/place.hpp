#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "rali/sim/world.hpp"

namespace rali::degeneracy_bench {

/// Scenes of the simulator by name, and tunnels with few features, in which a detector can err in
/// both directions.
///   tunnel_niches  a niche 0.7 m deep every 10 to 25 m
///   tunnel_end     80 m, a wall across each end
///   tunnel_rough   uneven walls, sd 2 to 4 cm (a mine has 6 cm)
inline constexpr std::array<std::string_view, 11> kPlaces{
    "tunnel", "tunnel_niches", "tunnel_end", "tunnel_rough", "corridor", "floor",
    "loop",   "garage",        "yard",       "mine",         "hall"};

/// The world with that name (also any other scene), or an error that lists the names. Another seed
/// gives another world of the same kind.
[[nodiscard]] Result<sim::World> make_place(std::string_view name, std::uint64_t seed);

}  // namespace rali::degeneracy_bench
