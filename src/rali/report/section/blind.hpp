#pragma once

#include <string>
#include <string_view>

#include "rali/report/run_data.hpp"

namespace rali::report {

/// Where the LiDAR was blind, along which axis, what held it there and how far off it may be: a row
/// of bars per vehicle and two tables (HTML).
[[nodiscard]] std::string blind_html(const RunData& run);

/// How much of the blind way had no range (HTML); empty if nothing was blind.
[[nodiscard]] std::string blind_without_ranges(const RunData& run);

/// The stretch of a vehicle that may be farthest off along its blind axis; null: none.
[[nodiscard]] const BlindSpan* worst_blind(const VehicleView& v);

}  // namespace rali::report
