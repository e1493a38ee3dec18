#pragma once

#include "rali/drive/map_run.hpp"
#include "rali/vehicle/vehicle.hpp"

namespace rali::drive {

/// What a vehicle's filter has measured of its sensors, beside what the settings state: age of
/// ranges at their stamps, noise of inertial data.
void take_measured(const vehicle::Vehicle& vehicle, const vehicle::VehicleSettings& settings,
                   VehicleSummary& summary);

}  // namespace rali::drive
