#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "rali/fleet/messages/messages.hpp"
#include "rali/fleet/node/explore_map.hpp"
#include "rali/fleet/node/goal_dispatcher.hpp"
#include "rali/fleet/node/job.hpp"

namespace rali::fleet {

/// Input of a frontier search, as it is at its start.
struct ExploreInput {
  JobKind kind = JobKind::kExplore;
  std::shared_ptr<const Placement> placed;
  std::vector<PeerState> fleet;
  VehicleId self;           ///< the anchor
  Time now;                 ///< by its clock
  bool facts_here = false;  ///< all stand still, are placed, and none of their facts are missing
  // For the last one of a round:
  std::optional<Time> progress_since;  ///< tests whether a vehicle reached a new place since then
  bool forget_points = false;          ///< points already drawn are not needed any more
};

struct ExploreResult {
  bool mapped = false;   ///< false: no ground is mapped yet, and all members below are unset
  bool progress = true;  ///< see ExploreInput::progress_since
  GoalList goals;        ///< without term and revision
  // For the last one of a round:
  std::vector<VehicleId> next_anchors;      ///< best first
  std::vector<GoalDispatcher::Stop> stops;  ///< if there was no progress
};

/// Draws new keyframes, searches frontiers and sends free vehicles. It owns the map while it runs,
/// and works on a copy of the current goals.
class ExploreJob final : public Job {
 public:
  /// @param place_m NodeSettings::place_m
  ExploreJob(GoalDispatcher dispatcher, double place_m)
      : dispatcher_(std::move(dispatcher)), place_m_(place_m) {}

  void run(Executor& executor, const std::atomic<bool>& cancel) override;

  [[nodiscard]] JobWork work() const override { return work_; }

 private:
  friend class Exploration;

  void look();
  void end_round(StopFlag stop);
  void count_searches(std::size_t paths);

  std::unique_ptr<ExploreMap> map_;
  std::vector<FactPtr> facts_;  ///< not added to the map yet
  GoalDispatcher dispatcher_;
  double place_m_;
  ExploreInput in_;
  ExploreResult result_;
  bool ended_ = false;
  JobWork work_;
};

}  // namespace rali::fleet
