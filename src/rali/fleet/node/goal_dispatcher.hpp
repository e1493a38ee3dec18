#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "rali/fleet/messages/messages.hpp"
#include "rali/fleet/node/explore_map.hpp"
#include "rali/fleet/node/settings.hpp"
#include "rali/fleet/rounds/goals.hpp"

namespace rali::fleet {

/// State of a vehicle, by its last status and the estimate.
struct PeerState {
  VehicleId vehicle;
  geometry::Vec2 place_map_m = geometry::Vec2::Zero();
  bool at_rest = false;
  bool stands = false;                     ///< keeps standstill: anchor, or finished
  bool no_further = false;                 ///< must not get farther from the anchor
  bool lost = false;                       ///< no message for long: it is assumed to stay there
  std::optional<DriveEnd> drive_end = {};  ///< result of the drive to its goal, if it has ended
};

/// Assigns vehicles to frontiers. A goal is kept until it is reached, missed, or observed from
/// afar, so that a new keyframe does not redirect a moving vehicle. look() takes tens of
/// milliseconds and belongs into jobs. A copy shares the picture of the grid.
class GoalDispatcher {
 public:
  explicit GoalDispatcher(const NodeSettings& settings)
      : settings_(settings), book_(settings.frontiers) {}

  /// Forgets the planned, missed and passed goals of the last round.
  void new_round();

  /// Continues with the frontier memory of the last anchor.
  void take_over(const map::FrontierMemory& newer) { book_.take(newer); }

  /// Reads the grid, settles goals that were reached or missed, and sends free vehicles.
  /// @param anchor index in `fleet`  @return false: nothing is mapped yet
  bool look(const ExploreMap& explored, std::span<const PeerState> fleet,
            std::optional<std::size_t> anchor, Time now);

  /// At the end of a round: a vehicle at standstill at a frontier has visited it.
  void note_who_stands(std::span<const PeerState> fleet);

  /// Ranks the vehicles as next anchor where all are at standstill, best first. It uses the last
  /// look and the goals missed under `anchor`: anchors under which others reach a frontier rank
  /// before those to which the others only close up.
  [[nodiscard]] std::vector<VehicleId> next_anchors(const ExploreMap& explored,
                                                    std::span<const PeerState> fleet,
                                                    VehicleId anchor) const;

  /// An open frontier and how close a vehicle can get to it, under the best anchor.
  struct Stop {
    std::uint32_t frontier = 0;  ///< id
    Reach reach = Reach::kNoPath;
  };

  /// The reasons why vehicles cannot reach the open frontiers, under the best anchor.
  [[nodiscard]] std::vector<Stop> stops(const ExploreMap& explored,
                                        std::span<const PeerState> fleet, VehicleId anchor) const;

  [[nodiscard]] GoalList goals(const ExploreMap& explored) const;

  [[nodiscard]] const std::vector<map::FrontierArea>& frontiers() const { return frontiers_; }

  /// The grid at the last look; null before.
  [[nodiscard]] const map::CellMap* map() const { return picture_ ? &picture_->map : nullptr; }

  /// The largest open one of the last look.
  [[nodiscard]] std::optional<std::uint32_t> largest() const;

 private:
  struct GoalTask {
    VehicleId vehicle;
    std::uint32_t frontier = 0;  ///< id
    geometry::Vec2 frontier_map_m = geometry::Vec2::Zero();
    std::vector<geometry::Vec2> places_map_m;
    bool cut = false;  ///< ends short of the frontier
    Time since;
    Time moved;  ///< when it last moved
  };

  /// Minimum distance of a vehicle to the anchor, and the distances before and after.
  struct Passage {
    double first_m = 0.0, min_m = 0.0, last_m = 0.0;
  };

  /// The grid at the last look.
  struct Picture {
    map::CellMap map;
    std::vector<std::uint8_t> passable;
  };

  [[nodiscard]] bool take_picture(const ExploreMap& explored);
  void watch_passages(std::span<const PeerState> fleet, std::size_t anchor);
  [[nodiscard]] bool has_passed(VehicleId vehicle) const;
  void find(std::span<const PeerState> fleet);
  void settle(std::span<const PeerState> fleet, Time now);
  [[nodiscard]] bool stands_beside(const PeerState& vehicle,
                                   std::span<const PeerState> fleet) const;
  [[nodiscard]] bool settled(GoalTask& task, const PeerState& at, bool beside_another, Time now);
  void arrived(const GoalTask& task);
  void gave_up(const GoalTask& task, DriveState state, bool beside_another);
  void send(const ExploreMap& explored, std::span<const PeerState> fleet,
            std::optional<std::size_t> anchor, Time now);
  [[nodiscard]] std::vector<std::size_t> open_frontiers() const;
  [[nodiscard]] std::vector<std::size_t> free_frontiers() const;
  [[nodiscard]] std::vector<FrontierSpot> spots_of(const std::vector<std::size_t>& which) const;
  /// Indices of spots that a vehicle is not sent to: it found no path, or did not arrive in this
  /// round.
  [[nodiscard]] std::vector<std::size_t> missed_by(VehicleId vehicle,
                                                   std::span<const FrontierSpot> spots,
                                                   bool in_this_round) const;
  [[nodiscard]] GoalTask task_of(const PlannedGoal& goal, const FrontierSpot& frontier,
                                 std::span<const PeerState> fleet,
                                 std::optional<std::size_t> anchor, Time now) const;
  [[nodiscard]] double link_min() const;
  [[nodiscard]] GoalPlan round_of(std::size_t anchor, std::span<const PeerState> fleet,
                                  std::span<const FrontierSpot> spots, const DegenerateAxisAt& axis,
                                  bool missed_counts, double link_min) const;

  NodeSettings settings_;
  map::FrontierBook book_;
  std::shared_ptr<const Picture> picture_;  ///< null before the first look
  std::vector<map::FrontierArea> frontiers_;
  std::vector<GoalTask> tasks_;
  // Of this round:
  std::vector<std::pair<VehicleId, geometry::Vec2>> missed_;  ///< frontiers
  std::set<VehicleId> shut_off_;                              ///< another vehicle blocked them
  std::set<VehicleId> not_past_;           ///< they found no path past the anchor
  std::map<VehicleId, Passage> passages_;  ///< by the anchor
};

}  // namespace rali::fleet
