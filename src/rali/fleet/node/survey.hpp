#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "rali/fleet/centre/round_centre.hpp"
#include "rali/fleet/facts/fact_store.hpp"
#include "rali/fleet/messages/messages.hpp"
#include "rali/fleet/node/placement.hpp"
#include "rali/fleet/node/settings.hpp"
#include "rali/fleet/node/survey_job.hpp"
#include "rali/fleet/path/fleet_paths.hpp"

namespace rali::fleet {

/// The map that an anchor makes of all facts: an estimate now and then, and between two of them
/// each vehicle's path as its own odometry continues it (algorithms_fleet 9.3, 9.5). Estimates are
/// jobs: nothing here solves.
class Survey {
 public:
  Survey(const NodeSettings& settings, const FleetKnowledge& known);

  /// Counts for paths at once, for the estimate from the next job on.
  void add(const FactPtr& fact);

  /// To solve for what is known. The job takes the centre with it: not while one is under way.
  /// @param end_round the round is over up to this time
  [[nodiscard]] std::shared_ptr<Job> make_job(std::optional<Time> end_round);

  /// Whether a job is under way.
  [[nodiscard]] bool is_solving() const { return centre_ == nullptr; }

  /// kTaken: its estimate holds from now on. kLost: restore() is needed.
  /// @param wanted false: the estimate is dropped
  [[nodiscard]] JobFate take_back(Job* job, bool wanted);

  /// Makes the centre of a job anew that will never come back. @param facts all that are held
  void restore(std::vector<FactPtr> facts);

  /// Goes on from where the last anchor had everything; see RoundCentre::take_over. What a job that
  /// is under way finds is stale then: it lies in other frames.
  bool take_over(const RoundBoundary& boundary,
                 const std::map<KeyframeId, KeyframePose>& keyframes);

  /// What the finished rounds leave to those to come; nothing while there is none.
  [[nodiscard]] const std::optional<RoundBoundary>& boundary() const { return boundary_; }

  /// Of the jobs that have come back.
  [[nodiscard]] const RoundCentre::Work& work() const { return work_; }

  /// Of the newest keyframe of a vehicle's epoch, in the map of the largest group. A vehicle that
  /// is not tied in yet is where it was measured at the start; nothing: nobody knows.
  [[nodiscard]] std::optional<geometry::SE3> T_map_odom(const StreamKey& stream) const;

  /// In its last epoch.
  [[nodiscard]] bool is_placed(VehicleId vehicle) const;

  [[nodiscard]] const FleetEstimate& last() const { return placed_->estimate; }

  /// Where everything lies by the last estimate; never null.
  [[nodiscard]] const std::shared_ptr<const Placement>& placed() const { return placed_; }

  /// What others are told: all frames, and the keyframes of the last estimate that moved farther
  /// since the last time. In parts.
  [[nodiscard]] std::vector<Table> tables(std::uint64_t term, std::uint32_t revision,
                                          double moved_m);

 private:
  [[nodiscard]] const VehiclePath* last_path_of(VehicleId vehicle) const;
  [[nodiscard]] const VehiclePath* first_path_of(VehicleId vehicle) const;
  [[nodiscard]] const VehiclePath* path_with(KeyframeId keyframe) const;
  [[nodiscard]] bool is_placed(const VehiclePath& path) const;
  [[nodiscard]] std::optional<geometry::SE3> measured(const StreamKey& stream) const;
  void take(FleetEstimate estimate);

  NodeSettings settings_;
  FleetKnowledge known_;
  std::unique_ptr<RoundCentre> centre_;  ///< null while a job has it
  std::vector<FactPtr> waiting_;         ///< that the centre has not got yet
  std::optional<Legacy> legacy_;         ///< likewise
  std::uint64_t generation_ = 0;         ///< of the frames: a new one with each legacy
  FleetPaths paths_;                     ///< without points, ranges and inertial data
  std::optional<RoundBoundary> boundary_;
  RoundCentre::Work work_;
  std::shared_ptr<const Placement> placed_ = std::make_shared<const Placement>();
  std::map<KeyframeId, geometry::SE3> told_;
};

}  // namespace rali::fleet
