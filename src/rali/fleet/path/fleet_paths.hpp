#pragma once

#include <span>
#include <vector>

#include "rali/fleet/path/vehicle_path.hpp"

namespace rali::fleet {

/// The paths of all vehicles, built from their facts in any order.
class FleetPaths {
 public:
  /// Duplicates of a fact with the same key must be removed before.
  void add(const FactPtr& fact);

  /// Those that have a node, by vehicle and epoch.
  [[nodiscard]] const std::vector<VehiclePath>& all() const { return paths_; }

  /// The path of a vehicle's last epoch; null while it has no node.
  [[nodiscard]] const VehiclePath* last_of(VehicleId vehicle) const;

  /// Frees the points of keyframes before these nodes, one for each path.
  void forget_points_before(std::span<const std::size_t> nodes);

 private:
  std::vector<VehiclePath> paths_, waiting_;  ///< waiting_: those without a node yet
};

}  // namespace rali::fleet
