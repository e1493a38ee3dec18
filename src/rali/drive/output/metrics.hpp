#pragma once

#include <string>
#include <string_view>

#include "rali/drive/map_run.hpp"

namespace rali::drive {

[[nodiscard]] std::string_view status_name(RunStatus status);

/// Text of metrics.json (schema 2). Numbers are rounded to their significant digits, so that the
/// text does not depend on the last bit; nothing in it depends on the wall clock.
[[nodiscard]] std::string metrics_text(const MapSummary& summary, const MapJob& job);

}  // namespace rali::drive
