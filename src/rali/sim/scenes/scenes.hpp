#pragma once

#include "rali/base/rng.hpp"
#include "rali/sim/world.hpp"

namespace rali::sim::scenes {

/// Ring of four corridors with rooms, about 165 m driven, the last metres over the first.
[[nodiscard]] World loop(Rng rng);
/// 2.4 m wide, one bend, few features: about 81 m driven.
[[nodiscard]] World corridor(Rng rng);
/// Storey with a hall, three corridors and junctions: about 89 m driven.
[[nodiscard]] World storey(Rng rng);

/// Open ground with buildings, containers, poles and trees inside a fence.
[[nodiscard]] World yard(Rng rng);
/// Parking deck of 60 x 40 m with equal pillars: looks the same every 8 m.
[[nodiscard]] World garage(Rng rng);

/// Smooth arched tunnel, 200 m, slightly bent: nothing to hold on to along it but a few niches.
[[nodiscard]] World tunnel(Rng rng);
/// Drift through rock with a junction, rough walls and uneven floor.
[[nodiscard]] World mine(Rng rng);
/// Two turns of a helical ramp with level ends.
[[nodiscard]] World ramp(Rng rng);

}  // namespace rali::sim::scenes
