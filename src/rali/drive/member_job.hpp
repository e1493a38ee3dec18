#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "rali/drive/map_run.hpp"

namespace rali::drive {

[[nodiscard]] std::vector<std::string> vehicle_names(const MapJob& job);

/// The vehicle's job with what the fleet knows.
[[nodiscard]] VehicleJob member_job(const MapJob& job, std::size_t index,
                                    const std::shared_ptr<const RangeOptions>& ranges);

/// The vehicle's settings with what its input has decided.
[[nodiscard]] vehicle::VehicleSettings settings_with(vehicle::VehicleSettings settings,
                                                     const InputReport& input);

/// Length of all vehicles' data together [s].
[[nodiscard]] double data_seconds(const MapSummary& summary);

}  // namespace rali::drive
