#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "rali/net/fleet_link.hpp"

namespace rali::net {

/// Links of a fleet within one process, for tests and for several vehicles in one program. What one
/// sends lies with the receiver at once, in order, and nothing is lost but what is cut.
class MemoryFleet {
 public:
  /// @param now the clock of Arrived::t  @param queue_max messages of kBulk that wait at a
  /// receiver; of the others the oldest is dropped for the newest
  MemoryFleet(std::vector<VehicleId> vehicles, std::function<Time()> now,
              std::size_t queue_max = 64);
  ~MemoryFleet();

  /// The link of one vehicle; lives no longer than the fleet. Each may be used by its own thread.
  [[nodiscard]] std::unique_ptr<FleetLink> link(VehicleId self);

  /// From now on nothing comes from `from` to `to`; the other direction has its own cut.
  void cut(VehicleId from, VehicleId to, bool is_cut);

  struct Hub;

 private:
  std::shared_ptr<Hub> hub_;
};

}  // namespace rali::net
