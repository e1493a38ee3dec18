#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "rali/map/explore_grid.hpp"

namespace rali::map {

/// Cells where the middle of a vehicle may be: free, and farther than `radius_m` from every
/// obstacle. Same order as `map.cells`; 1 or 0.
[[nodiscard]] std::vector<std::uint8_t> passable_cells(const CellMap& map, double radius_m);

/// Where somebody stands no other can be: closes the cells nearer than `radius_m`.
void close_around(const CellMap& map, const geometry::Vec2& place_map_m, double radius_m,
                  std::vector<std::uint8_t>& passable);

/// Shortest ways from one place over passable cells, in eight directions (Dijkstra).
class PathField {
 public:
  /// A start that is not passable itself (beside a wall, in one's own shadow) begins at the nearest
  /// passable cell within `escape_m`; without one nothing is reached. `map` must outlive this.
  PathField(const CellMap& map, const std::vector<std::uint8_t>& passable,
            const geometry::Vec2& start_map_m, double escape_m = 1.0);

  /// Length of the way [m]; infinite if there is none.
  [[nodiscard]] double length_m(const CellMap::Cell& to) const;

  /// The way from the start, corners only: straight pieces over passable cells. Empty if there is
  /// none.
  [[nodiscard]] std::vector<geometry::Vec2> path_to(const CellMap::Cell& to) const;

 private:
  void flood(std::size_t start);
  [[nodiscard]] bool sees(const CellMap::Cell& a, const CellMap::Cell& b) const;

  const CellMap* map_;
  const std::vector<std::uint8_t>* passable_;
  std::vector<float> length_m_;
  std::vector<std::uint8_t> from_;  ///< direction that the way came by; 8: start or none
};

/// Chance of sight between two places (algorithms_fleet 10.3, P_los): 0 if an obstacle is between
/// them, 0.5 if something unknown is, else 1. Obstacles within 0.5 m of the ends are the vehicles
/// themselves.
[[nodiscard]] double sight_share(const CellMap& map, const geometry::Vec2& from_map_m,
                                 const geometry::Vec2& to_map_m);

}  // namespace rali::map
