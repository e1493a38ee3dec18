#include "rali/drive/ranges/start_prior.hpp"

#include "rali/fleet/centre/start_between.hpp"

namespace rali::drive {

std::optional<vehicle::PeerPrior> prior_between(std::span<const fleet::GivenStart> starts,
                                                VehicleId self, VehicleId peer) {
  const auto known = fleet::start_between(starts, self, peer);
  if (!known) return std::nullopt;
  return vehicle::PeerPrior{known->T_relative_vehicle, known->sigma_m, known->sigma_rad};
}

}  // namespace rali::drive
