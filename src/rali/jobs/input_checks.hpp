#pragma once

#include <string>

#include "rali/base/result.hpp"
#include "rali/config/fleet_config.hpp"

namespace rali::jobs {

/// Where a key of the settings was given; the key itself if it was not.
[[nodiscard]] std::string origin_of(const config::FleetConfig& fleet, const std::string& key);

/// The files beside the recordings (ranges, radio, rounds) must exist, be readable and have their
/// columns; checked before any computation. Errors: kInput.
[[nodiscard]] Status check_side_files(const config::FleetConfig& fleet);

/// Each recording must be of a readable kind. Errors: kInput, with the place that names it.
[[nodiscard]] Status check_recordings(const config::FleetConfig& fleet);

}  // namespace rali::jobs
