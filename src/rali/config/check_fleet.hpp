#pragma once

#include <string>

#include "rali/config/fleet_config.hpp"

namespace rali::config {

/// What no single value tells: a vehicle without recording, a lower bound above the upper one, a
/// name that is no vehicle. `name` is the file, for what has no line of its own.
/// @param live the sensors are there: recordings are not needed
/// Errors: kUsage, where = the line of the value that does not fit.
[[nodiscard]] Status check_fleet(const FleetConfig& config, const std::string& name, bool live);

}  // namespace rali::config
