#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "rali/fleet/centre/round_centre.hpp"
#include "rali/fleet/facts/fact_store.hpp"
#include "rali/fleet/messages/messages.hpp"
#include "rali/fleet/node/fleet_mapper_job.hpp"
#include "rali/fleet/node/placement.hpp"
#include "rali/fleet/node/settings.hpp"
#include "rali/fleet/path/fleet_paths.hpp"

namespace rali::fleet {

/// The map that an anchor makes of all facts: an estimate at intervals. Between two estimates each
/// vehicle's own odometry continues its path (algorithms_fleet 9.3, 9.5). Estimates are jobs: this
/// class does not solve.
class FleetMapper {
 public:
  FleetMapper(const NodeSettings& settings, const FleetKnowledge& known);

  /// Is used for paths at once, for the estimate from the next job on.
  void add(const FactPtr& fact);

  /// Job that solves for all known facts. It takes ownership of the centre: not while one is
  /// running.
  /// @param end_round the round is over up to this time
  [[nodiscard]] std::shared_ptr<Job> make_job(std::optional<Time> end_round);

  /// Whether a job is under way.
  [[nodiscard]] bool is_solving() const { return centre_ == nullptr; }

  /// kTaken: its estimate is valid from now on. kLost: restore() is needed.
  /// @param wanted false: the estimate is dropped
  [[nodiscard]] JobOutcome take_back(Job* job, bool wanted);

  /// Rebuilds the centre of a job that will never return. @param facts all that are held
  void restore(std::vector<FactPtr> facts);

  /// Continues from the estimate of the last anchor; see RoundCentre::take_over. The result of a
  /// running job is stale then: it refers to other frames.
  bool take_over(const SeparatorPrior& separator,
                 const std::map<KeyframeId, KeyframePose>& keyframes);

  /// The separator prior that finished rounds leave to later ones; nothing before the first.
  [[nodiscard]] const std::optional<SeparatorPrior>& separator() const { return separator_; }

  /// Of the jobs that have returned.
  [[nodiscard]] const RoundCentre::Work& work() const { return work_; }

  /// At the newest keyframe of a vehicle's epoch, in the map of the largest group. A vehicle that
  /// is not connected yet has its measured start pose; nothing if there is none.
  [[nodiscard]] std::optional<geometry::SE3> T_map_odom(const StreamKey& stream) const;

  /// In its last epoch.
  [[nodiscard]] bool is_placed(VehicleId vehicle) const;

  [[nodiscard]] const FleetEstimate& last() const { return placed_->estimate; }

  /// Poses of all paths by the last estimate; never null.
  [[nodiscard]] const std::shared_ptr<const Placement>& placed() const { return placed_; }

  /// Tables for the others, in parts: all frames, and those keyframes of the last estimate that
  /// were corrected by more than `moved_m` since they were last sent.
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
  std::vector<FactPtr> waiting_;         ///< not added to the centre yet
  std::optional<Legacy> legacy_;         ///< likewise
  std::uint64_t generation_ = 0;         ///< of the frames: incremented with each legacy
  FleetPaths paths_;                     ///< without points and ranges
  std::optional<SeparatorPrior> separator_;
  RoundCentre::Work work_;
  std::shared_ptr<const Placement> placed_ = std::make_shared<const Placement>();
  std::map<KeyframeId, geometry::SE3> reported_;
};

}  // namespace rali::fleet
