#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "rali/fleet/messages/messages.hpp"
#include "rali/fleet/node/errands.hpp"
#include "rali/fleet/node/explore_map.hpp"
#include "rali/fleet/node/job.hpp"

namespace rali::fleet {

/// What a search for frontiers is made from, as it is when it begins.
struct ExploreInput {
  JobKind kind = JobKind::kExplore;
  std::shared_ptr<const Placement> placed;
  std::vector<Whereabouts> fleet;
  VehicleId self;           ///< the anchor
  Time now;                 ///< by its clock
  bool facts_here = false;  ///< all rest, are placed, and nothing of them is missing
  // Of the last one of a round:
  std::optional<Time> progress_since;  ///< asks whether a vehicle came to a new place from then on
  bool forget_points = false;          ///< those that are drawn are not needed any more
};

struct ExploreResult {
  bool mapped = false;   ///< false: no ground is seen yet, and nothing else below is known
  bool progress = true;  ///< see ExploreInput::progress_since
  GoalList goals;        ///< without term and revision
  // Of the last one of a round:
  std::vector<VehicleId> next_anchors;  ///< best first
  std::vector<Errands::Stop> stops;     ///< if there was no progress
};

/// Draws what is new, looks for frontiers and sends who is free. It owns the map while it is under
/// way, and works on a copy of who is on the way to where.
class ExploreJob final : public Job {
 public:
  /// @param place_m NodeSettings::place_m
  ExploreJob(Errands errands, double place_m) : errands_(std::move(errands)), place_m_(place_m) {}

  void run(Executor& executor, const std::atomic<bool>& cancel) override;

  [[nodiscard]] JobWork work() const override { return work_; }

 private:
  friend class Exploration;

  void look();
  void end_round(StopFlag stop);
  void count_searches(std::size_t paths);

  std::unique_ptr<ExploreMap> map_;
  std::vector<FactPtr> facts_;  ///< that the map does not have yet
  Errands errands_;
  double place_m_;
  ExploreInput in_;
  ExploreResult result_;
  bool ended_ = false;
  JobWork work_;
};

}  // namespace rali::fleet
