#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "rali/drive/map_run.hpp"

namespace rali::drive {

[[nodiscard]] std::vector<std::string> vehicle_names(const MapJob& job);

/// The vehicle's job, completed with what is known for the whole fleet.
[[nodiscard]] VehicleJob member_job(const MapJob& job, std::size_t index,
                                    const std::shared_ptr<const RangeOptions>& ranges);

/// The vehicle's settings, completed with the decisions about its input.
[[nodiscard]] vehicle::VehicleSettings settings_with(vehicle::VehicleSettings settings,
                                                     const InputReport& input);

/// Length of all vehicles' data together [s].
[[nodiscard]] double data_seconds(const MapSummary& summary);

}  // namespace rali::drive
