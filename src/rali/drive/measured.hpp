#pragma once

#include "rali/drive/map_run.hpp"
#include "rali/vehicle/vehicle.hpp"

namespace rali::drive {

/// Copies sensor properties measured by a vehicle's filter into the summary, beside those of the
/// settings: stamp latency of ranges, noise of inertial data.
void take_measured(const vehicle::Vehicle& vehicle, const vehicle::VehicleSettings& settings,
                   VehicleSummary& summary);

}  // namespace rali::drive
