#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "rali/fleet/node/errands.hpp"
#include "rali/fleet/node/explore_job.hpp"

namespace rali::fleet {

/// Where the anchor looks for frontiers and sends the others. What draws and searches is a job;
/// here is what it found last, and who is on the way to where.
class Exploration {
 public:
  explicit Exploration(const NodeSettings& settings)
      : settings_(settings),
        map_(std::make_unique<ExploreMap>(settings.explore)),
        errands_(settings) {}

  /// Counts from the next job on.
  void add(const FactPtr& fact) { waiting_.push_back(fact); }

  /// What was sent, missed and passed in the last round is forgotten. What a job that is under way
  /// finds is stale: it must not be wanted.
  void new_round() { errands_.new_round(); }

  /// Goes on with what the last anchor remembered of frontiers; likewise.
  void take_over(const map::FrontierMemory& newer) { errands_.take_over(newer); }

  /// The job takes the map with it: not while one is under way.
  [[nodiscard]] std::shared_ptr<Job> make_job(ExploreInput in);

  /// kLost: restore() is needed. @param wanted false: what it found is dropped
  [[nodiscard]] JobFate take_back(Job* job, bool wanted);

  /// Makes the map of a job anew that will never come back. @param facts all that are held
  void restore(std::vector<FactPtr> facts);

  /// Of the last job that was taken.
  [[nodiscard]] const ExploreInput& input() const { return input_; }

  [[nodiscard]] const ExploreResult& result() const { return result_; }

  [[nodiscard]] const Errands& errands() const { return errands_; }

  /// What jobs have drawn so far; null while one is under way.
  [[nodiscard]] const ExploreMap* map() const { return map_.get(); }

 private:
  NodeSettings settings_;
  std::unique_ptr<ExploreMap> map_;  ///< null while a job has it
  std::vector<FactPtr> waiting_;     ///< that the map has not got yet
  Errands errands_;
  ExploreInput input_;
  ExploreResult result_;
};

}  // namespace rali::fleet
