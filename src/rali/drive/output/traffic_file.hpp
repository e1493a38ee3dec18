#pragma once

#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/fleet/messages/kind.hpp"

namespace rali::drive {

/// Writes traffic.csv: what each vehicle sent by radio, by kind of message, into a folder that
/// exists. Errors: kMachine.
/// @param names of the vehicles, by their number  @param duration_s of the mission
[[nodiscard]] Status write_traffic_table(const std::string& folder,
                                         const std::vector<std::string>& names,
                                         const std::vector<fleet::TrafficCount>& reported,
                                         double duration_s);

/// Megabytes per minute; 0 for a duration of 0.
[[nodiscard]] double mb_per_min(std::uint64_t bytes, double duration_s);

}  // namespace rali::drive
