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

/// Where a vehicle is, as its last status and the estimate have it.
struct Whereabouts {
  VehicleId vehicle;
  geometry::Vec2 place_map_m = geometry::Vec2::Zero();
  bool at_rest = false;
  bool stands = false;      ///< anchor, or finished
  bool no_further = false;  ///< no goal farther from the anchor
  bool lost = false;        ///< nothing was heard of it for long: it stands there for good
  std::optional<DriveEnd> drive_end = {};  ///< of its goal, if the drive has ended
};

/// Who is on the way to which frontier. A goal lives until it is reached, missed, or seen from
/// afar: a vehicle on its way is not sent elsewhere by every new keyframe. Looking is for jobs: it
/// takes tens of milliseconds. A copy shares the picture of the grid.
class Errands {
 public:
  explicit Errands(const NodeSettings& settings) : settings_(settings), book_(settings.frontiers) {}

  /// What was planned, missed and passed in the last round is forgotten.
  void new_round();

  /// Goes on with what the last anchor remembered of frontiers.
  void take_over(const map::FrontierMemory& newer) { book_.take(newer); }

  /// Looks at the grid, settles what has been reached or missed, and sends whoever is free.
  /// @param anchor index in `fleet`  @return false: nothing is mapped yet
  bool look(const ExploreMap& explored, std::span<const Whereabouts> fleet,
            std::optional<std::size_t> anchor, Time now);

  /// At the end of a round: whoever stands at a frontier has visited it.
  void note_who_stands(std::span<const Whereabouts> fleet);

  /// Who should be next anchor where everybody stands, best first, by the last look and by what
  /// was missed while `anchor` stood: under whom the others get to a frontier, before whom they
  /// only close up behind.
  [[nodiscard]] std::vector<VehicleId> next_anchors(const ExploreMap& explored,
                                                    std::span<const Whereabouts> fleet,
                                                    VehicleId anchor) const;

  /// An open frontier and how near a vehicle could come to it, under the best anchor.
  struct Stop {
    std::uint32_t frontier = 0;  ///< id
    Reach reach = Reach::kNoPath;
  };

  /// Likewise: what keeps the vehicles from the open frontiers.
  [[nodiscard]] std::vector<Stop> stops(const ExploreMap& explored,
                                        std::span<const Whereabouts> fleet, VehicleId anchor) const;

  [[nodiscard]] GoalList goals(const ExploreMap& explored) const;

  [[nodiscard]] const std::vector<map::FrontierArea>& frontiers() const { return frontiers_; }

  /// The grid as it was looked at last; null before.
  [[nodiscard]] const map::CellMap* map() const { return picture_ ? &picture_->map : nullptr; }

  /// Of the last look, the largest open one.
  [[nodiscard]] std::optional<std::uint32_t> largest() const;

 private:
  struct Errand {
    VehicleId vehicle;
    std::uint32_t frontier = 0;  ///< id
    geometry::Vec2 frontier_map_m = geometry::Vec2::Zero();
    std::vector<geometry::Vec2> places_map_m;
    bool cut = false;  ///< ends before the frontier
    Time since;
    Time moved;  ///< when it was last seen moving
  };

  /// How near a vehicle has come to the anchor, and how far it was before.
  struct Passage {
    double first_m = 0.0, least_m = 0.0, last_m = 0.0;
  };

  /// The grid as it was looked at.
  struct Picture {
    map::CellMap map;
    std::vector<std::uint8_t> passable;
  };

  [[nodiscard]] bool take_picture(const ExploreMap& explored);
  void watch_passages(std::span<const Whereabouts> fleet, std::size_t anchor);
  [[nodiscard]] bool has_passed(VehicleId vehicle) const;
  void find(std::span<const Whereabouts> fleet);
  void settle(std::span<const Whereabouts> fleet, Time now);
  [[nodiscard]] bool settled(Errand& errand, const Whereabouts& at, Time now);
  void arrived(const Errand& errand);
  void gave_up(const Errand& errand, DriveState state);
  void send(const ExploreMap& explored, std::span<const Whereabouts> fleet,
            std::optional<std::size_t> anchor, Time now);
  [[nodiscard]] std::vector<std::size_t> open_frontiers() const;
  [[nodiscard]] std::vector<std::size_t> free_frontiers() const;
  [[nodiscard]] std::vector<FrontierSpot> spots_of(const std::vector<std::size_t>& which) const;
  /// Indices of spots that a vehicle is not sent to: it found no path, or did not get there in this
  /// round.
  [[nodiscard]] std::vector<std::size_t> missed_by(VehicleId vehicle,
                                                   std::span<const FrontierSpot> spots,
                                                   bool in_this_round) const;
  [[nodiscard]] Errand errand_of(const PlannedGoal& goal, const FrontierSpot& frontier,
                                 std::span<const Whereabouts> fleet,
                                 std::optional<std::size_t> anchor, Time now) const;
  [[nodiscard]] double link_min() const;
  [[nodiscard]] GoalPlan round_of(std::size_t anchor, std::span<const Whereabouts> fleet,
                                  std::span<const FrontierSpot> spots, const BlindAxisAt& axis,
                                  bool missed_counts, double link_min) const;

  NodeSettings settings_;
  map::FrontierBook book_;
  std::shared_ptr<const Picture> picture_;  ///< null before the first look
  std::vector<map::FrontierArea> frontiers_;
  std::vector<Errand> errands_;
  // Of this round:
  std::vector<std::pair<VehicleId, geometry::Vec2>> missed_;  ///< frontiers
  std::set<VehicleId> shut_off_;                              ///< another vehicle blocked them
  std::set<VehicleId> not_past_;           ///< they found no path past the anchor
  std::map<VehicleId, Passage> passages_;  ///< by the anchor
};

}  // namespace rali::fleet
