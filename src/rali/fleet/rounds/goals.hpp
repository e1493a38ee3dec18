#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "rali/fleet/rounds/anchor_choice.hpp"

namespace rali::fleet {

/// A vehicle whose path is to be planned.
struct Traveller {
  VehicleId vehicle;
  geometry::Vec2 place_map_m = geometry::Vec2::Zero();
  bool stands = false;      ///< anchor, or finished: gets no goal, and paths are linked to it
  bool passed = false;      ///< has driven past the anchor in this round already
  bool no_further = false;  ///< warned (FinishView::warn): no goal farther from the anchor
  bool wide = false;        ///< could not pass a vehicle: keeps around_m from all at standstill
  std::vector<std::size_t> missed = {};  ///< indices of frontiers that it did not reach
};

/// How close a path brings a vehicle to a frontier, best last.
enum class Reach : std::uint8_t {
  kNoPath,   ///< none in the map, or the vehicle is not to try again
  kBlocked,  ///< another vehicle blocks every path
  kTooFar,   ///< farther from the anchor than the vehicle may drive
  kNoLink,   ///< no range to a vehicle at standstill where the LiDAR is degenerate
  kThere
};

/// The reason why vehicles cannot reach a frontier, a sentence without a full stop.
[[nodiscard]] std::string_view reason_of(Reach reach);

/// Goal of a vehicle in this round.
struct PlannedGoal {
  VehicleId vehicle;
  std::optional<std::size_t> frontier;     ///< index; none: stays at standstill as an additional
                                           ///< anchor
  std::vector<geometry::Vec2> path_map_m;  ///< corners, from its position; empty: stays at
                                           ///< standstill
  double path_m = 0.0;
  Reach reach = Reach::kNoPath;
  bool passes = false;  ///< leads past the anchor

  /// The path ends short of the frontier.
  [[nodiscard]] bool is_cut() const { return reach != Reach::kThere; }
};

struct GoalPlan {
  std::vector<PlannedGoal> goals;  ///< one per traveller, in their order
  /// Least link probability along the paths, 1 where the LiDAR is not degenerate: shown to the
  /// user.
  double link_min = 1.0;
  std::vector<Reach> reach;  ///< by frontier: the best of all vehicles not at standstill
};

/// Assigns goals (algorithms_fleet 10.4): vehicles that may move are assigned to frontiers so that
/// the sum of path lengths minus size_weight * size is least, at most one per frontier; the rest
/// stay at standstill. Paths lead around vehicles at standstill. Where no path leads past them, in
/// a narrow corridor, a vehicle closes up to around_m behind the one in its path. Each place of a
/// path needs a range to a vehicle at standstill with a probability of at least link_min, or no
/// degeneracy (`degenerate_axis` returns none). Else the path is cut before it; paths that need no
/// cut are preferred. `anchor`: index in `travellers`. With pass_anchor, paths lead past it where
/// that costs at most pass_detour_m and the vehicle has not passed yet (10.3: passing makes the
/// pair's bias observable).
[[nodiscard]] GoalPlan plan_goals(std::span<const Traveller> travellers,
                                  std::optional<std::size_t> anchor,
                                  std::span<const FrontierSpot> frontiers, const map::CellMap& map,
                                  const std::vector<std::uint8_t>& passable,
                                  const DegenerateAxisAt& degenerate_axis,
                                  const AnchorSettings& links, const GoalSettings& settings);

/// Whether a vehicle with these distances to a place (first, minimum, last) has passed it: within
/// near_m, and both ends farther away than the nearest point by at least 1 m.
[[nodiscard]] bool is_passage(double first_m, double min_m, double last_m, double near_m);

/// Whether a path passes a place.
[[nodiscard]] bool leads_past(std::span<const geometry::Vec2> path_map_m,
                              const geometry::Vec2& place_map_m, double near_m);

/// Length of a path [m].
[[nodiscard]] double length_of(std::span<const geometry::Vec2> path_map_m);

}  // namespace rali::fleet
