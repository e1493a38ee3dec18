#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "rali/fleet/node/explore_job.hpp"
#include "rali/fleet/node/goal_dispatcher.hpp"

namespace rali::fleet {

/// Frontier search and goal assignment of the anchor. Drawing and searching are a job; this class
/// keeps the last result and the current goals.
class Exploration {
 public:
  explicit Exploration(const NodeSettings& settings)
      : settings_(settings),
        map_(std::make_unique<ExploreMap>(settings.explore)),
        dispatcher_(settings) {}

  /// Is used from the next job on.
  void add(const FactPtr& fact) { waiting_.push_back(fact); }

  /// Forgets the sent, missed and passed goals of the last round. The result of a running job is
  /// stale then and must be dropped.
  void new_round() { dispatcher_.new_round(); }

  /// Continues with the frontier memory of the last anchor; a running job is stale then too.
  void take_over(const map::FrontierMemory& newer) { dispatcher_.take_over(newer); }

  /// The job takes ownership of the map: not while one is running.
  [[nodiscard]] std::shared_ptr<Job> make_job(ExploreInput in);

  /// kLost: restore() is needed. @param wanted false: the result is dropped
  [[nodiscard]] JobOutcome take_back(Job* job, bool wanted);

  /// Rebuilds the map of a job that will never return. @param facts all that are held
  void restore(std::vector<FactPtr> facts);

  /// Of the last job whose result was taken.
  [[nodiscard]] const ExploreInput& input() const { return input_; }

  [[nodiscard]] const ExploreResult& result() const { return result_; }

  [[nodiscard]] const GoalDispatcher& dispatcher() const { return dispatcher_; }

  /// The map drawn by the jobs so far; null while one is running.
  [[nodiscard]] const ExploreMap* map() const { return map_.get(); }

 private:
  NodeSettings settings_;
  std::unique_ptr<ExploreMap> map_;  ///< null while a job has it
  std::vector<FactPtr> waiting_;     ///< not added to the map yet
  GoalDispatcher dispatcher_;
  ExploreInput input_;
  ExploreResult result_;
};

}  // namespace rali::fleet
