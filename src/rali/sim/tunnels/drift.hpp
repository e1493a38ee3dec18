#pragma once

#include "rali/sim/tunnels/tube.hpp"
#include "rali/sim/world.hpp"

namespace rali::sim {

/// Shape and clutter of a drift through rock.
struct DriftShape {
  ArchShape arch;
  double roughness_m = 0.30;
  double clutter_every_m = 6.5;  ///< 0: none
};

/// A mine along a given axis.
[[nodiscard]] World drift_world(const Route& axis, const DriftShape& shape, std::uint64_t seed,
                                Rng& rng);

}  // namespace rali::sim
