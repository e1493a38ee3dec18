#include "rali/fleet/centre/centre.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "rali/fleet/centre/solution.hpp"

namespace rali::fleet {

namespace {

std::vector<VehiclePath>::iterator place_of(std::vector<VehiclePath>& paths, StreamKey stream) {
  return std::lower_bound(
      paths.begin(), paths.end(), stream,
      [](const VehiclePath& path, StreamKey key) { return stream_of(path) < key; });
}

}  // namespace

Centre::Centre(const FleetSettings& settings, FleetKnowledge knowledge)
    : settings_(settings), knowledge_(std::move(knowledge)) {}

void Centre::add(const Fact& fact) {
  const StreamKey stream{fact.key.vehicle, fact.key.epoch};
  const auto known = place_of(paths_, stream);
  if (known != paths_.end() && stream_of(*known) == stream) return known->add(fact.t, fact.body);
  auto path = place_of(waiting_, stream);
  if (path == waiting_.end() || stream_of(*path) != stream) {
    path = waiting_.insert(path, VehiclePath(stream.vehicle, stream.epoch));
  }
  path->add(fact.t, fact.body);
  if (path->nodes().empty()) return;
  paths_.insert(known, std::move(*path));
  waiting_.erase(path);
}

FleetEstimate Centre::estimate(Executor& executor) const {
  return solve_fleet({.paths = paths_, .knowledge = knowledge_, .settings = settings_}, executor)
      .estimate;
}

void Centre::forget_points_before(std::span<const std::size_t> nodes) {
  for (std::size_t i = 0; i < std::min(paths_.size(), nodes.size()); ++i) {
    paths_[i].forget_points_before(nodes[i]);
  }
}

}  // namespace rali::fleet
