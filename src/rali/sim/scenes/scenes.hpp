#pragma once

#include "rali/base/rng.hpp"
#include "rali/sim/world.hpp"

namespace rali::sim::scenes {

/// Ring of four corridors with rooms, about 165 m driven, the last metres over the first.
[[nodiscard]] World loop(Rng rng);
/// 2.4 m wide, one bend, few features: about 81 m driven.
[[nodiscard]] World corridor(Rng rng);

}  // namespace rali::sim::scenes
