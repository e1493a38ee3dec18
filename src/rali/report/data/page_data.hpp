#pragma once

#include <string>
#include <vector>

#include "rali/report/run_data.hpp"

namespace rali::report {

/// Maximum number of vehicle pairs whose residuals are drawn.
inline constexpr std::size_t kPairsDrawn = 12;

/// The data for the scripts of the page: JSON without '<', arrays as base64 of little-endian
/// values. Its size is bounded for any run.
[[nodiscard]] std::string page_data(const RunData& run);

/// The same for several runs: the paths of each vehicle in all runs, the map of the first.
[[nodiscard]] std::string page_data(const std::vector<RunData>& runs);

}  // namespace rali::report
