#pragma once

#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/config/load_fleet.hpp"

namespace rali::jobs {

/// The fleet that the inputs of a mapping run describe: one fleet.yaml, or recordings, one vehicle
/// each. Errors: as config::load_fleet; kUsage for a fleet.yaml among other inputs.
[[nodiscard]] Result<config::FleetConfig> load_inputs(const std::vector<std::string>& inputs,
                                                      const config::Overrides& overrides);

/// Formats in which the map can be written: pcd, ply, las.
/// @param where the option or key that names the format, for the message. Errors: kUsage.
[[nodiscard]] Status check_format(const std::string& format, const std::string& where);

}  // namespace rali::jobs
