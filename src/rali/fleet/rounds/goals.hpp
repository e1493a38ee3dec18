#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "rali/fleet/rounds/anchor_choice.hpp"

namespace rali::fleet {

/// A vehicle whose way is to be planned.
struct Traveller {
  VehicleId vehicle;
  geometry::Vec2 place_map_m = geometry::Vec2::Zero();
  bool stands = false;      ///< anchor, or finished: gets no goal, and ways are linked to it
  bool passed = false;      ///< has driven past the anchor in this round already
  bool no_further = false;  ///< warned (FinishView::warn): no goal farther from the anchor
  bool wide = false;        ///< could not get past somebody: keeps around_m from all who stand
  std::vector<std::size_t> missed = {};  ///< indices of frontiers that it did not get to
};

/// How near a path brings a vehicle to a frontier, best last.
enum class Reach : std::uint8_t {
  kNoPath,   ///< none in the map, or the vehicle is not to try again
  kBlocked,  ///< another vehicle stands in every path
  kTooFar,   ///< farther from the anchor than the vehicle may go
  kNoLink,   ///< no range to anybody where the LiDAR is degenerate
  kThere
};

/// What keeps vehicles from a frontier, a sentence without a full stop.
[[nodiscard]] std::string_view reason_of(Reach reach);

/// Where a vehicle goes in this round.
struct PlannedGoal {
  VehicleId vehicle;
  std::optional<std::size_t> frontier;     ///< index; none: stands as one more anchor
  std::vector<geometry::Vec2> path_map_m;  ///< corners, from where it is; empty: stands
  double path_m = 0.0;
  Reach reach = Reach::kNoPath;
  bool passes = false;  ///< leads past the anchor

  /// The path ends before the frontier.
  [[nodiscard]] bool is_cut() const { return reach != Reach::kThere; }
};

struct GoalPlan {
  std::vector<PlannedGoal> goals;  ///< one per traveller, in their order
  /// The least chance along the ways, 1 where the LiDAR sees all: told to the user.
  double link_least = 1.0;
  std::vector<Reach> reach;  ///< by frontier: the best of all who do not stand
};

/// Who goes where (algorithms_fleet 10.4): vehicles that do not stand are assigned to frontiers so
/// that the sum of ways minus size_weight * size is least, at most one per frontier; whoever is
/// left stands. Ways lead around those who stand. Where there is none past them, in a narrow
/// corridor, a vehicle closes up to around_m behind the one in its path. Each place of a way has a
/// chance of at least link_min of a range to somebody who stands, or the LiDAR sees all there
/// (`blind_axis` says none); else the way is cut before it, and ways that need no cut come first.
/// `anchor`: index in `travellers`; with pass_anchor, ways lead past it where that costs at most
/// pass_detour_m and the vehicle has not passed yet (10.3: passing makes the pair's bias
/// observable).
[[nodiscard]] GoalPlan plan_goals(std::span<const Traveller> travellers,
                                  std::optional<std::size_t> anchor,
                                  std::span<const FrontierSpot> frontiers, const map::CellMap& map,
                                  const std::vector<std::uint8_t>& passable,
                                  const BlindAxisAt& blind_axis, const AnchorSettings& links,
                                  const GoalSettings& settings);

/// Whether somebody who was so far from a place at first, at the nearest, and at last has passed
/// it: within near_m, and both ends farther away than the nearest point by at least 1 m.
[[nodiscard]] bool is_passage(double first_m, double least_m, double last_m, double near_m);

/// Whether a way passes a place.
[[nodiscard]] bool leads_past(std::span<const geometry::Vec2> path_map_m,
                              const geometry::Vec2& place_map_m, double near_m);

/// Length of a way [m].
[[nodiscard]] double length_of(std::span<const geometry::Vec2> path_map_m);

}  // namespace rali::fleet
