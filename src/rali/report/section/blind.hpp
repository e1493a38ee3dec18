#pragma once

#include <string>

#include "rali/report/run_data.hpp"

namespace rali::report {

/// Where the LiDAR was blind, along which axis, what held it there and how far off it may be: a row
/// of bars per vehicle and a table (HTML).
[[nodiscard]] std::string blind_html(const RunData& run);

/// The stretch of a vehicle that may be farthest off along its blind axis; null: none.
[[nodiscard]] const BlindSpan* worst_blind(const VehicleView& v);

/// "in the direction it drove", "up and down", ... (plain text)
[[nodiscard]] std::string axis_words(const BlindSpan& span);

/// Share of the way that was blind and held by no range.
[[nodiscard]] double unheld_share(const VehicleNumbers& n);

}  // namespace rali::report
