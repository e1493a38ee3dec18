#pragma once

#include <optional>
#include <span>

#include "rali/fleet/centre/knowledge.hpp"

namespace rali::fleet {

/// Start pose of `vehicle` relative to `from`, by the shortest chain of start poses measured by
/// hand; nothing if there is none. The error due to the heading of `from` is in sigma_rad, across
/// the line to `vehicle`, as for a direct measurement. Heading errors of intermediate vehicles
/// displace what was measured from them, which is in sigma_m.
[[nodiscard]] std::optional<GivenStart> start_between(std::span<const GivenStart> starts,
                                                      VehicleId from, VehicleId vehicle);

}  // namespace rali::fleet
