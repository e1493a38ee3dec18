#pragma once

#include <string>
#include <string_view>

#include "rali/report/run_data.hpp"

namespace rali::report {

/// Where the LiDAR was degenerate, along which axis, what constrained the vehicle there and how
/// large its error may be: a row of bars per vehicle and two tables (HTML).
[[nodiscard]] std::string degenerate_html(const RunData& run);

}  // namespace rali::report
