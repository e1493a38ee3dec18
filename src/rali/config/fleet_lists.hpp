#pragma once

#include "rali/config/fleet_config.hpp"

namespace rali::config {

/// The lists and maps of fleet.yaml that have their own syntax.
[[nodiscard]] CustomTarget antennas_target(std::vector<AntennaConfig>& antennas);
[[nodiscard]] CustomTarget range_sources_target(std::vector<RangeSource>& sources,
                                                const std::string& base_dir);
[[nodiscard]] CustomTarget range_bias_target(RangesConfig& ranges);
[[nodiscard]] CustomTarget priors_target(std::vector<PriorConfig>& priors);

}  // namespace rali::config
