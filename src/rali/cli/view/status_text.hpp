#pragma once

#include <string>
#include <string_view>

#include "rali/base/result.hpp"

namespace rali::cli {

struct FleetStatus {
  std::string text;    ///< mission, vehicles, links, ranges, what is wrong; a dash: not known
  bool alarm = false;  ///< the anchor is lost, or a diagnostic has level `error`
};

/// The fleet in a terminal, from the JSON of `/rali/state` (src/rali/view/README.md). Errors:
/// kInput for what is no state.
[[nodiscard]] Result<FleetStatus> read_status(std::string_view state);

}  // namespace rali::cli
