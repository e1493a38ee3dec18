#pragma once

#include "case.hpp"
#include "rali/sim/fleet/fleet_simulation.hpp"

namespace rali::campaign {

/// The place of the case with starts and rounds as its plan asks. Stops are noted in the case.
/// Errors: of the place; a way too short for so many vehicles.
[[nodiscard]] Result<sim::World> planned_world(Case& c, const Ranges& ranges);

}  // namespace rali::campaign
