#pragma once

#include <optional>
#include <span>

#include "rali/fleet/centre/knowledge.hpp"
#include "rali/vehicle/settings.hpp"

namespace rali::drive {

/// The peer's first pose relative to one's own, from start poses measured by hand; empty if no
/// chain of them connects the two.
[[nodiscard]] std::optional<vehicle::PeerPrior> prior_between(
    std::span<const fleet::GivenStart> starts, VehicleId self, VehicleId peer);

}  // namespace rali::drive
