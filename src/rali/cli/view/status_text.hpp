#pragma once

#include <string>
#include <string_view>

#include "rali/base/result.hpp"

namespace rali::cli {

struct FleetStatus {
  std::string text;    ///< mission, vehicles, links, ranges, problems; a dash: unknown
  bool alarm = false;  ///< the anchor is lost, or a diagnostic has level `error`
};

/// The fleet's state as terminal text, from the JSON of `/rali/state` (src/rali/view/README.md).
/// Errors: kInput if it is not a state.
[[nodiscard]] Result<FleetStatus> read_status(std::string_view state);

}  // namespace rali::cli
