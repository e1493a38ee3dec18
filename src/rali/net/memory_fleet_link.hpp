#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "rali/net/fleet_link.hpp"

namespace rali::net {

/// Links of a fleet within one process, for tests and for several vehicles in one program. A
/// message is delivered at once, in order, and lost only on a cut link.
class MemoryFleet {
 public:
  /// @param now the clock of Arrived::t  @param queue_max messages of kBulk that wait at a
  /// receiver; for other kinds the newest replaces the oldest
  MemoryFleet(std::vector<VehicleId> vehicles, std::function<Time()> now,
              std::size_t queue_max = 64);
  ~MemoryFleet();

  /// The link of one vehicle; must not outlive the fleet. Each may be used by its own thread.
  [[nodiscard]] std::unique_ptr<FleetLink> link(VehicleId self);

  /// Cuts or restores the link from `from` to `to`; the other direction is separate.
  void cut(VehicleId from, VehicleId to, bool is_cut);

  struct Hub;

 private:
  std::shared_ptr<Hub> hub_;
};

}  // namespace rali::net
