#include "rali/fleet/path/fleet_paths.hpp"

#include <algorithm>
#include <utility>

namespace rali::fleet {

namespace {

bool is_of(const VehiclePath& path, const FactKey& key) {
  return path.vehicle() == key.vehicle && path.epoch() == key.epoch;
}

std::vector<VehiclePath>::iterator place_of(std::vector<VehiclePath>& paths, const FactKey& key) {
  return std::lower_bound(paths.begin(), paths.end(), std::pair(key.vehicle, key.epoch),
                          [](const VehiclePath& path, const auto& stream) {
                            return std::pair(path.vehicle(), path.epoch()) < stream;
                          });
}

}  // namespace

void FleetPaths::add(const FactPtr& fact) {
  const FactKey& key = fact->key;
  const auto known = place_of(paths_, key);
  if (known != paths_.end() && is_of(*known, key)) return known->add(fact);
  auto path = place_of(waiting_, key);
  if (path == waiting_.end() || !is_of(*path, key)) {
    path = waiting_.insert(path, VehiclePath(key.vehicle, key.epoch));
  }
  path->add(fact);
  if (path->nodes().empty()) return;
  paths_.insert(known, std::move(*path));
  waiting_.erase(path);
}

const VehiclePath* FleetPaths::last_of(VehicleId vehicle) const {
  const VehiclePath* found = nullptr;
  for (const VehiclePath& path : paths_) {
    if (path.vehicle() == vehicle) found = &path;
  }
  return found;
}

void FleetPaths::forget_points_before(std::span<const std::size_t> nodes) {
  for (std::size_t i = 0; i < std::min(paths_.size(), nodes.size()); ++i) {
    paths_[i].forget_points_before(nodes[i]);
  }
}

}  // namespace rali::fleet
