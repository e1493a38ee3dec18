#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "rali/fleet/centre/round_centre.hpp"
#include "rali/fleet/facts/fact_store.hpp"
#include "rali/fleet/messages/messages.hpp"
#include "rali/fleet/node/settings.hpp"
#include "rali/fleet/node/survey_job.hpp"
#include "rali/fleet/path/fleet_paths.hpp"
#include "rali/fleet/rounds/anchor_choice.hpp"
#include "rali/map/explore_grid.hpp"

namespace rali::fleet {

/// The map that an anchor makes of all facts: an estimate now and then, and between two of them
/// each vehicle's path as its own odometry continues it (algorithms_fleet 9.3, 9.5). Estimates are
/// jobs: nothing here solves.
class Survey {
 public:
  Survey(const NodeSettings& settings, const FleetKnowledge& known);

  /// Counts for paths and grid at once, for the estimate from the next job on.
  void add(const FactPtr& fact);

  /// To solve for what is known. The job takes the centre with it: not while one is under way.
  /// @param end_round the round is over up to this time
  [[nodiscard]] std::shared_ptr<Job> make_job(std::optional<Time> end_round);

  /// Whether a job is under way.
  [[nodiscard]] bool is_solving() const { return centre_ == nullptr; }

  /// What became of a job that has come back.
  enum class Back {
    kTaken,    ///< its estimate holds from now on, and the grid's keyframes lie as it says
    kDropped,  ///< it was cancelled or is stale; what it was made from is here again
    kLost      ///< not the job that was made: restore() is needed
  };

  /// @param wanted false: the estimate is dropped
  [[nodiscard]] Back take_back(Job* job, bool wanted);

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

  /// Puts keyframes into the grid that have come since. @return how many
  std::size_t refresh();

  /// Of the newest keyframe of a vehicle's epoch, in the map of the largest group. A vehicle that
  /// is not tied in yet is where it was measured at the start; nothing: nobody knows.
  [[nodiscard]] std::optional<geometry::SE3> T_map_odom(const StreamKey& stream) const;

  /// In its last epoch.
  [[nodiscard]] bool is_placed(VehicleId vehicle) const;

  [[nodiscard]] const map::ExploreGrid& grid() const { return grid_; }

  [[nodiscard]] const FleetEstimate& last() const { return last_; }

  /// The direction that a LiDAR will not tell at a place: as at the nearest node of any path.
  [[nodiscard]] BlindAxisAt blind_axis() const;

  /// Height of the bodies near a place [m].
  [[nodiscard]] double height_m(const geometry::Vec2& place_map_m) const;

  /// Keyframes made from a time on at places where no vehicle had been before it.
  [[nodiscard]] std::size_t new_places_since(Time t) const;

  [[nodiscard]] std::size_t keyframes() const { return grid_.keyframes(); }

  /// What others are told: all frames, and the keyframes that moved farther since the last time. In
  /// parts.
  [[nodiscard]] std::vector<Table> tables(std::uint64_t term, std::uint32_t revision,
                                          double moved_m);

 private:
  struct Seen {
    geometry::Vec2 p_map_m = geometry::Vec2::Zero();
    double z_m = 0.0;
    std::optional<geometry::Vec2> blind_axis;
  };

  [[nodiscard]] const VehiclePath* last_path_of(VehicleId vehicle) const;
  [[nodiscard]] const VehiclePath* first_path_of(VehicleId vehicle) const;
  [[nodiscard]] const VehiclePath* path_with(KeyframeId keyframe) const;
  [[nodiscard]] bool is_placed(const VehiclePath& path) const;
  [[nodiscard]] std::optional<geometry::SE3> measured(const StreamKey& stream) const;
  [[nodiscard]] geometry::SE3 pose_of(const VehiclePath& path, std::size_t node) const;
  void take(FleetEstimate estimate);
  void forget_drawn_points();
  void find_frames();
  void list_seen();

  NodeSettings settings_;
  FleetKnowledge known_;
  std::unique_ptr<RoundCentre> centre_;  ///< null while a job has it
  std::vector<FactPtr> waiting_;         ///< that the centre has not got yet
  std::optional<Legacy> legacy_;         ///< likewise
  std::uint64_t generation_ = 0;         ///< of the frames: a new one with each legacy
  FleetPaths paths_;                     ///< without points, ranges and inertial data
  std::map<StreamKey, std::map<std::uint32_t, FactPtr>> points_;  ///< by keyframe, for the grid
  std::optional<RoundBoundary> boundary_;
  RoundCentre::Work work_;
  FleetEstimate last_;
  std::map<StreamKey, geometry::SE3> T_map_odom_;  ///< of those in the largest group
  map::ExploreGrid grid_;
  std::map<KeyframeId, geometry::SE3> in_grid_;
  std::map<KeyframeId, geometry::SE3> told_;
  std::vector<Seen> seen_;  ///< of all nodes
};

}  // namespace rali::fleet
