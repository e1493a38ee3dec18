#pragma once

#include <string>

#include "rali/report/run_data.hpp"

namespace rali::report {

/// Residuals over time, a plot per pair: the ranges used as small dots, each reason of a rejection
/// with a marker and a colour of its own; what has no residual stands in a rail below (HTML).
/// Empty if there is no range between two vehicles.
[[nodiscard]] std::string range_plots_html(const RunData& run);

}  // namespace rali::report
