#pragma once

#include "case.hpp"
#include "rali/sim/fleet/fleet_simulation.hpp"

namespace rali::campaign {

/// The world of the case with starts and rounds by its plan. Stops are added to the case.
/// Errors: of the world; a path too short for so many vehicles.
[[nodiscard]] Result<sim::World> planned_world(Case& c, const Ranges& ranges);

}  // namespace rali::campaign
