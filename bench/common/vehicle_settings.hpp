#pragma once

#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/fleet/centre/fleet_settings.hpp"
#include "rali/vehicle/settings.hpp"

namespace rali::bench {

/// The defaults with these "key=value" of fleet.yaml's `settings:`. Errors (kUsage): as of `--set`.
[[nodiscard]] Result<vehicle::VehicleSettings> vehicle_settings(
    const std::vector<std::string>& assignments);

/// The same for the joint estimate of a fleet.
[[nodiscard]] Result<fleet::FleetSettings> fleet_settings(
    const std::vector<std::string>& assignments);

}  // namespace rali::bench
