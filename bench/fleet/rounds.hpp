#pragma once

#include <string>

#include "join.hpp"

namespace rali::fleet_bench {

/// One row per round: how far the fleet has come, what its newest keyframes are off by as known at
/// the end of the round, and at the end of the mission, and what the estimate cost. Markdown.
[[nodiscard]] std::string round_table(const Mission& mission, const Joined& joined);

}  // namespace rali::fleet_bench
