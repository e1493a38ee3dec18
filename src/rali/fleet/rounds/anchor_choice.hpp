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

/// A vehicle that may become anchor, with its position.
struct AnchorCandidate {
  VehicleId vehicle;
  geometry::Vec2 place_map_m = geometry::Vec2::Zero();
};

/// A frontier as input of the choice.
struct FrontierSpot {
  std::uint32_t id = 0;
  geometry::Vec2 centre_map_m = geometry::Vec2::Zero();
  double size = 0.0;
};

/// Length of the path of candidate i to frontier k [m]; infinite: none.
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

/// A position of a tag in the next round, and the horizontal direction (unit) in which its LiDAR
/// will be degenerate there; none: not degenerate, no range needed.
struct PredictedLandmark {
  geometry::Vec2 place_map_m = geometry::Vec2::Zero();
  std::optional<geometry::Vec2> degenerate_axis;
};

/// Predicted degenerate axis at a place: from the map's normals; in unknown space the last one is
/// continued.
using DegenerateAxisAt =
    std::function<std::optional<geometry::Vec2>(const geometry::Vec2& place_map_m)>;

/// Places every spacing_m along a path, its end included.
[[nodiscard]] std::vector<PredictedLandmark> predict_places(
    std::span<const geometry::Vec2> path_map_m, const DegenerateAxisAt& degenerate_axis,
    double spacing_m);

/// Probability that a range over this distance arrives: logistic, one half at range_limit_m.
[[nodiscard]] double link_chance(double distance_m, const AnchorSettings& settings);

/// V(a) = sum over k of P_los P_link min(1, c_k^2 / c_sat^2), c_k = e_k.(q_k - a)/|q_k - a|
/// (algorithms_fleet 10.3): number of places that an anchor at `a` helps.
[[nodiscard]] double anchor_value(const geometry::Vec2& place_map_m,
                                  std::span<const PredictedLandmark> predicted,
                                  const map::CellMap& map, const AnchorSettings& settings);

/// A place for an anchor, and its value.
struct RankedAnchor {
  VehicleId vehicle;
  geometry::Vec2 place_map_m = geometry::Vec2::Zero();
  double path_m = 0.0;  ///< path to drive there first
  double value = 0.0;   ///< V
  double score = 0.0;   ///< V - path_cost * path_m
};

/// What other vehicles can do while a candidate is anchor, best last.
enum class AnchorUse : std::uint8_t {
  kNone,
  kCloseUp,  ///< no vehicle can pass it or another one, but they can come nearer
  kExplore   ///< a vehicle has a path to a frontier
};

/// A candidate and the round that would follow.
struct AnchorOption {
  AnchorCandidate candidate;
  AnchorUse use = AnchorUse::kExplore;
  std::vector<PredictedLandmark> predicted;  ///< on the paths of the others
};

/// Each candidate at its best place within near_m of its position, best first: first by its use,
/// then by its score. Equal scores: the one nearer to the largest frontier, then the lowest number.
/// With the paper's choice: by distance to the largest frontier, score = -distance, each at its
/// current position. `passable` as from map::passable_cells.
[[nodiscard]] std::vector<RankedAnchor> rank_anchors(std::span<const AnchorOption> options,
                                                     std::span<const FrontierSpot> frontiers,
                                                     const map::CellMap& map,
                                                     const std::vector<std::uint8_t>& passable,
                                                     const AnchorSettings& settings);

}  // namespace rali::fleet
