#pragma once

#include <optional>
#include <span>

#include "rali/fleet/centre/knowledge.hpp"
#include "rali/vehicle/settings.hpp"

namespace rali::drive {

/// The peer's first pose in one's own, by what was measured of both by hand; nothing if no chain
/// leads from the one to the other.
[[nodiscard]] std::optional<vehicle::PeerPrior> prior_between(
    std::span<const fleet::GivenStart> starts, VehicleId self, VehicleId peer);

}  // namespace rali::drive
