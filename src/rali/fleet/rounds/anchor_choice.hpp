#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "rali/base/ids.hpp"
#include "rali/fleet/rounds/settings.hpp"
#include "rali/map/explore_paths.hpp"

namespace rali::fleet {

/// A vehicle that may become anchor, at its place.
struct AnchorCandidate {
  VehicleId vehicle;
  geometry::Vec2 place_map_m = geometry::Vec2::Zero();
};

/// A frontier as the choice sees it.
struct FrontierSpot {
  std::uint32_t id = 0;
  geometry::Vec2 centre_map_m = geometry::Vec2::Zero();
  double size = 0.0;
};

/// Length of the way of candidate i to frontier k [m]; infinite: none.
using PathLengths = std::function<double(std::size_t candidate, std::size_t frontier)>;

struct PaperAnchor {
  VehicleId vehicle;
  std::size_t frontier = 0;  ///< index of the largest one
  double distance_m = 0.0;
};

/// The paper's rule (section "Dynamically Anchor Role Selection"; algorithms_fleet 10.3): the
/// candidate nearest to the centre of the largest frontier. Equal sizes: the first; equal
/// distances: the lowest vehicle number. None without frontier or candidate. `path_m` empty:
/// straight distances.
[[nodiscard]] std::optional<PaperAnchor> nearest_to_largest(
    std::span<const AnchorCandidate> candidates, std::span<const FrontierSpot> frontiers,
    const PathLengths& path_m = {});

/// A place where a tag will be in the next round, and the horizontal direction (unit) that its
/// LiDAR will not see there; none: it sees all, and needs no range.
struct PredictedPlace {
  geometry::Vec2 place_map_m = geometry::Vec2::Zero();
  std::optional<geometry::Vec2> blind_axis;
};

/// Predicted blind axis at a place: from the map's normals, in unknown space the last one
/// continued.
using BlindAxisAt = std::function<std::optional<geometry::Vec2>(const geometry::Vec2& place_map_m)>;

/// Places every spacing_m along a way, its end included.
[[nodiscard]] std::vector<PredictedPlace> predict_places(std::span<const geometry::Vec2> path_map_m,
                                                         const BlindAxisAt& blind_axis,
                                                         double spacing_m);

/// Chance that a range over this distance arrives: logistic, one half at range_limit_m.
[[nodiscard]] double link_chance(double distance_m, const AnchorSettings& settings);

/// V(a) = sum over k of P_los P_link min(1, c_k^2 / c_sat^2), c_k = e_k.(q_k - a)/|q_k - a|
/// (algorithms_fleet 10.3): how many of the places an anchor at `a` helps.
[[nodiscard]] double anchor_value(const geometry::Vec2& place_map_m,
                                  std::span<const PredictedPlace> predicted,
                                  const map::CellMap& map, const AnchorSettings& settings);

/// A place for an anchor, and its worth.
struct RankedAnchor {
  VehicleId vehicle;
  geometry::Vec2 place_map_m = geometry::Vec2::Zero();
  double path_m = 0.0;  ///< to drive there first
  double value = 0.0;   ///< V
  double score = 0.0;   ///< V - path_cost * path_m
};

/// What others can do while a candidate stands, best last.
enum class AnchorUse : std::uint8_t {
  kNone,
  kCloseUp,  ///< nobody gets past it, or another one, but they can come nearer
  kExplore   ///< somebody has a path to a frontier
};

/// A candidate and the round that would follow.
struct AnchorOption {
  AnchorCandidate candidate;
  AnchorUse use = AnchorUse::kExplore;
  std::vector<PredictedPlace> predicted;  ///< on the ways of the others
};

/// Each candidate at its best place, within near_m of where it stands, best first: first by its
/// use, then by its score. Equal scores: the one nearer to the largest frontier, then the lowest
/// number. With the paper's choice: by distance to the largest frontier, score = -distance,
/// everyone where it is. `passable` as from map::passable_cells.
[[nodiscard]] std::vector<RankedAnchor> rank_anchors(std::span<const AnchorOption> options,
                                                     std::span<const FrontierSpot> frontiers,
                                                     const map::CellMap& map,
                                                     const std::vector<std::uint8_t>& passable,
                                                     const AnchorSettings& settings);

}  // namespace rali::fleet
