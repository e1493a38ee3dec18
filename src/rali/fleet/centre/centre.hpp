#pragma once

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/base/stop_flag.hpp"
#include "rali/fleet/centre/compared_pieces.hpp"
#include "rali/fleet/centre/estimate.hpp"
#include "rali/fleet/centre/fleet_settings.hpp"
#include "rali/fleet/centre/knowledge.hpp"
#include "rali/fleet/facts/facts.hpp"
#include "rali/fleet/path/fleet_paths.hpp"

namespace rali::fleet {

/// The temporary centre of the fleet: makes one map of all vehicles from their facts (paper,
/// "Global optimisation"; algorithms_fleet 7 to 9). The result does not depend on the vehicle it
/// runs on: the same facts give the same estimate, in whatever order they arrive.
class Centre {
 public:
  Centre(const FleetSettings& settings, FleetKnowledge knowledge);

  /// Duplicates of a fact with the same key must be removed before.
  void add(const FactPtr& fact) { paths_.add(fact); }

  void add(Fact fact) { add(std::make_shared<const Fact>(std::move(fact))); }

  /// Joins the frames, searches loops and solves for all known facts. The result is invalid if the
  /// flag was raised meanwhile.
  /// @param compared in earlier estimates; null: none
  [[nodiscard]] FleetEstimate estimate(Executor& executor, ComparedPieces* compared = nullptr,
                                       StopFlag stop = {}) const;

  /// Those that have a node, by vehicle and epoch.
  [[nodiscard]] const std::vector<VehiclePath>& paths() const { return paths_.all(); }

  [[nodiscard]] const FleetSettings& settings() const { return settings_; }

  [[nodiscard]] const FleetKnowledge& knowledge() const { return knowledge_; }

  /// Frees the points of keyframes before these nodes, one for each path.
  void forget_points_before(std::span<const std::size_t> nodes) {
    paths_.forget_points_before(nodes);
  }

 private:
  FleetSettings settings_;
  FleetKnowledge knowledge_;
  FleetPaths paths_;
};

}  // namespace rali::fleet
