#pragma once

#include "rali/drive/vehicle_run.hpp"
#include "rali/fleet/centre/estimate.hpp"

namespace rali::drive {

/// Tells a vehicle where the fleet's joint estimate has its frame and its keyframes; nothing if the
/// estimate leaves the vehicle to itself.
void join_path(const fleet::FleetEstimate& estimate, VehicleId vehicle, VehicleRun& run);

}  // namespace rali::drive
