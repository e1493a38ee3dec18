#pragma once

#include <map>
#include <optional>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/fleet/centre/round_centre.hpp"
#include "rali/fleet/messages/messages.hpp"
#include "rali/fleet/node/settings.hpp"
#include "rali/fleet/rounds/anchor_choice.hpp"
#include "rali/map/explore_grid.hpp"

namespace rali::fleet {

/// The map that an anchor makes of all facts: an estimate now and then, and between two of them
/// each vehicle's path as its own odometry continues it (algorithms_fleet 9.3, 9.5).
class Survey {
 public:
  Survey(const NodeSettings& settings, const FleetKnowledge& known);

  void add(const Fact& fact) { centre_.add(fact); }

  /// Solves for what is known, and moves the grid's keyframes along.
  void estimate(Executor& executor);

  /// The last estimate of a round, which is over up to `t`; puts new keyframes into the grid, too.
  void end_round(Time t, Executor& executor);

  /// Goes on from where the last anchor had everything; see RoundCentre::take_over.
  bool take_over(const RoundBoundary& boundary,
                 const std::map<KeyframeId, KeyframePose>& keyframes);

  /// What the finished rounds leave to those to come; nothing while there is none.
  [[nodiscard]] const std::optional<RoundBoundary>& boundary() const { return centre_.boundary(); }

  [[nodiscard]] const RoundCentre::Work& work() const { return centre_.work(); }

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
  void take(const FleetEstimate& estimate);
  void find_frames();
  void list_seen();

  NodeSettings settings_;
  FleetKnowledge known_;
  RoundCentre centre_;
  FleetEstimate last_;
  std::map<StreamKey, geometry::SE3> T_map_odom_;  ///< of those in the largest group
  map::ExploreGrid grid_;
  std::map<KeyframeId, geometry::SE3> in_grid_;
  std::map<KeyframeId, geometry::SE3> told_;
  std::vector<Seen> seen_;  ///< of all nodes
};

}  // namespace rali::fleet
