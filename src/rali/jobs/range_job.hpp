#pragma once

#include <vector>

#include "rali/base/result.hpp"
#include "rali/config/fleet_config.hpp"
#include "rali/drive/ranges/range_options.hpp"
#include "rali/fleet/centre/centre.hpp"
#include "rali/vehicle/settings.hpp"

namespace rali::jobs {

/// Sources of the ranges of a fleet; vehicles are numbered by their order.
/// Errors (kUsage): a source that this version cannot read.
[[nodiscard]] Result<drive::RangeOptions> range_options(const config::FleetConfig& fleet);

/// Sets a vehicle's prior knowledge of ranges and peers: its antennas, the peers' antennas, their
/// start poses, the quality of ranges.
/// @param index of the vehicle in the fleet
void set_ranging(const config::FleetConfig& fleet, std::size_t index,
                 vehicle::VehicleSettings& settings);

/// The user's knowledge of the fleet as a whole: start poses, calibrated radios, clocks.
[[nodiscard]] fleet::FleetKnowledge fleet_knowledge(const config::FleetConfig& fleet);

}  // namespace rali::jobs
