#pragma once

#include <span>
#include <vector>

#include "rali/fleet/path/vehicle_path.hpp"

namespace rali::fleet {

/// The paths of all vehicles, gathered from their facts in whatever order these come.
class FleetPaths {
 public:
  /// Facts of which there is more than one of the same key are to be sorted out before.
  void add(const FactKey& key, Time t, const FactBody& body);

  /// Those that have a node, by vehicle and epoch.
  [[nodiscard]] const std::vector<VehiclePath>& all() const { return paths_; }

  /// The path of a vehicle's last epoch; null while it has no node.
  [[nodiscard]] const VehiclePath* last_of(VehicleId vehicle) const;

  /// Points of keyframes before these nodes, one for each path, are not needed any more.
  void forget_points_before(std::span<const std::size_t> nodes);

 private:
  std::vector<VehiclePath> paths_, waiting_;  ///< those that wait have no node yet
};

}  // namespace rali::fleet
