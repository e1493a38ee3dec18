#pragma once

#include <string>

#include "join.hpp"

namespace rali::fleet_bench {

/// One row per round in Markdown: path length of the fleet, errors of its newest keyframes as
/// estimated at the end of the round and of the mission, and cost of the estimate.
[[nodiscard]] std::string round_table(const Mission& mission, const Joined& joined);

}  // namespace rali::fleet_bench
