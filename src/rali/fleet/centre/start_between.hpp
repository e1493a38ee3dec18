#pragma once

#include <optional>
#include <span>

#include "rali/fleet/centre/knowledge.hpp"

namespace rali::fleet {

/// Where `vehicle` starts as seen from where `from` does, by the shortest chain of what was
/// measured by hand; nothing if there is none. What errs by the heading of `from` is in sigma_rad,
/// across the line to it, as it is where it was measured from there; the headings of those between
/// swing what was measured from them, which is in sigma_m.
[[nodiscard]] std::optional<GivenStart> start_between(std::span<const GivenStart> starts,
                                                      VehicleId from, VehicleId vehicle);

}  // namespace rali::fleet
