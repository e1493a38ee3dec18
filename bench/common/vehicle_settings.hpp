#pragma once

#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/vehicle/settings.hpp"

namespace rali::bench {

/// The defaults with these "key=value" of fleet.yaml's `settings:`. Errors (kUsage): as of `--set`.
[[nodiscard]] Result<vehicle::VehicleSettings> vehicle_settings(
    const std::vector<std::string>& assignments);

}  // namespace rali::bench
