#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "rali/base/settings.hpp"
#include "rali/map/explore_paths.hpp"
#include "rali/map/named_frontier.hpp"

namespace rali::map {

enum class FrontierSize : std::uint8_t { kCells, kLength, kUnknownArea };
inline constexpr ChoiceNames<3> kFrontierSizeNames = {"cells", "length", "unknown_area"};

enum class FrontierCentre : std::uint8_t { kMean, kMedoid };
inline constexpr ChoiceNames<2> kFrontierCentreNames = {"mean", "medoid"};

/// What counts as a frontier (algorithms_fleet 10.2).
struct FrontierSettings {
  FrontierSize size = FrontierSize::kCells;
  FrontierCentre centre = FrontierCentre::kMedoid;
  /// Of cells that the centre of a vehicle reaches: the opening is wider by twice radius_m.
  double length_min_m = 0.6;
  double radius_m = 0.3;         ///< obstacles are widened by this
  double merge_m = 2.0;          ///< a frontier nearer than this to an earlier one keeps its id
  double unknown_reach_m = 5.0;  ///< unknown space behind a frontier counts up to here
  double visit_m = 1.0;          ///< nearer than this is a visit
  double visits_max = 2.0;       ///< visits without change after which a frontier is given up

  template <class V>
  void visit(V& v) {
    v.choice("size", size, kFrontierSizeNames, "what makes a frontier large");
    v.choice("centre", centre, kFrontierCentreNames, "its centre; the mean may lie in a wall");
    v("length_min_m", length_min_m, 0.0, 100.0, "shorter ones are none [m]");
    v("radius_m", radius_m, 0.0, 5.0, "obstacles are widened by this [m]");
    v("merge_m", merge_m, 0.0, 50.0,
      "a frontier nearer than this to an earlier one keeps its id [m]");
    v("unknown_reach_m", unknown_reach_m, 0.5, 50.0, "unknown space counts up to here [m]");
    v("visit_m", visit_m, 0.1, 20.0, "nearer than this is a visit [m]");
    v("visits_max", visits_max, 1.0, 100.0, "visits without change until it is given up");
  }
};

enum class FrontierState : std::uint8_t { kOpen, kExplored, kTooSmall, kUnreachable };

/// Edge between free and unknown space.
struct FrontierArea {
  std::uint32_t id = 0;  ///< given by FrontierBook, from 1; constant for the frontier's life
  FrontierState state = FrontierState::kOpen;
  std::vector<CellMap::Cell> cells;  ///< of its map, by index
  geometry::Vec2 centre_map_m = geometry::Vec2::Zero();
  double length_m = 0.0;  ///< side of a cell times the number of cells
  double unknown_area_m2 = 0.0;
  double size = 0.0;        ///< by FrontierSettings::size: cells, m or m2
  std::size_t nearest = 0;  ///< index of the vehicle with the shortest path to it
  double path_m = 0.0;      ///< length of that path; infinite if unreachable
  bool tried = false;       ///< unreachable though the map shows a path: no vehicle found one
};

/// All frontiers of a map, by their first cell: free cells with an unknown neighbour that a vehicle
/// can occupy, joined in eight directions (Yamauchi 1997; algorithms_fleet 10.2). `from` are the
/// path fields of the vehicles; a frontier that none of them reaches is kUnreachable, one that is
/// too short kTooSmall. Both are returned, so that "no frontier" has a reason (U39).
[[nodiscard]] std::vector<FrontierArea> find_frontiers(const CellMap& map,
                                                       const std::vector<std::uint8_t>& passable,
                                                       std::span<const PathField> from,
                                                       const FrontierSettings& settings);

/// Gives frontiers persistent ids, and gives up those that visits do not change (glass, gaps
/// between rings).
class FrontierBook {
 public:
  explicit FrontierBook(const FrontierSettings& settings) : settings_(settings) {}

  /// Sets the id and, for those given up, kExplored. Call it with each new list.
  void name(std::vector<FrontierArea>& frontiers);

  /// A vehicle has arrived here, on its way to a frontier or by chance; call it once per arrival.
  void visited(const geometry::Vec2& place_map_m);

  /// A vehicle sent here found no path. Unlike a visit, this is no evidence of what lies behind.
  void found_no_path(VehicleId vehicle, const geometry::Vec2& place_map_m);

  [[nodiscard]] bool has_no_path(VehicleId vehicle, const geometry::Vec2& place_map_m) const;

  /// Open frontiers to which no vehicle found a path become kUnreachable.
  void give_up_unreached(std::vector<FrontierArea>& frontiers,
                         std::span<const VehicleId> vehicles) const;

  /// Continues from another, newer book: frontiers keep their ids and visits.
  void take(const FrontierMemory& newer);

  /// The frontiers of the last list, or those taken over.
  [[nodiscard]] FrontierMemory memory() const;

 private:
  struct Entry {
    NamedFrontier frontier;
    bool present = false;  ///< in the last list
  };

  [[nodiscard]] Entry* entry_of(const FrontierArea& frontier);

  FrontierSettings settings_;
  std::vector<Entry> entries_;  ///< one per frontier of the last list
  std::vector<NoPath> no_path_;
  std::uint32_t last_id_ = 0;
};

}  // namespace rali::map
