#pragma once

#include <string>
#include <vector>

#include "rali/report/run_data.hpp"

namespace rali::report {

/// Pairs of vehicles whose residuals are drawn.
inline constexpr std::size_t kPairsDrawn = 12;

/// The numbers that the scripts of the page draw from: JSON without '<', arrays as base64 of
/// little-endian values. Its size has a bound, whatever the run holds.
[[nodiscard]] std::string page_data(const RunData& run);

/// The same of runs side by side: the paths of each vehicle in all runs, the map of the first.
[[nodiscard]] std::string page_data(const std::vector<RunData>& runs);

}  // namespace rali::report
