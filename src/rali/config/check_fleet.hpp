#pragma once

#include <string>

#include "rali/config/fleet_config.hpp"

namespace rali::config {

/// Checks across several values: a vehicle without recording, a lower bound above the upper one, an
/// unknown vehicle name. `name` is the file, for problems without a line of their own.
/// @param live sensors supply the data: recordings are not needed
/// Errors: kUsage, where = the line of the wrong value.
[[nodiscard]] Status check_fleet(const FleetConfig& config, const std::string& name, bool live);

}  // namespace rali::config
