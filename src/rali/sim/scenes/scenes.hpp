#pragma once

#include "rali/base/rng.hpp"
#include "rali/sim/world.hpp"

namespace rali::sim::scenes {

/// Ring of four corridors with rooms, about 165 m driven; the last metres overlap the first.
[[nodiscard]] World loop(Rng rng);
/// 2.4 m wide, one bend, few features: about 81 m driven.
[[nodiscard]] World corridor(Rng rng);
/// Storey with a hall, three corridors and junctions: about 89 m driven.
[[nodiscard]] World storey(Rng rng);

/// Open ground with buildings, containers, poles and trees inside a fence.
[[nodiscard]] World yard(Rng rng);
/// Parking deck of 60 x 40 m with equal pillars: geometry repeats every 8 m.
[[nodiscard]] World garage(Rng rng);

/// Works hall with machines, gates and columns at the walls: walls far away, few near surfaces.
[[nodiscard]] World hall(Rng rng);
/// Racks with goods on both sides of narrow aisles: geometry repeats every 2.7 m and every aisle.
[[nodiscard]] World warehouse(Rng rng);

/// Smooth arched tunnel, 200 m, slightly bent, open ends: degenerate along its axis.
[[nodiscard]] World tunnel(Rng rng);
/// Winding drift through rock with rough walls and an uneven floor.
[[nodiscard]] World mine(Rng rng);
/// Two turns of a helical ramp with level ends.
[[nodiscard]] World ramp(Rng rng);

}  // namespace rali::sim::scenes
