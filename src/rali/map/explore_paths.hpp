#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "rali/map/explore_grid.hpp"

namespace rali::map {

/// Cells where the middle of a vehicle may be: free, and farther than `radius_m` from every
/// obstacle. Same order as `map.cells`; 1 or 0.
[[nodiscard]] std::vector<std::uint8_t> passable_cells(const CellMap& map, double radius_m);

/// Closes the cells nearer than `radius_m` to another vehicle.
void close_around(const CellMap& map, const geometry::Vec2& place_map_m, double radius_m,
                  std::vector<std::uint8_t>& passable);

/// Shortest paths from one position over passable cells, in eight directions (Dijkstra).
class PathField {
 public:
  /// If the start is not passable (beside a wall, in the vehicle's own shadow), the nearest
  /// passable cell within `escape_m` replaces it; without one nothing is reached. `map` must
  /// outlive this.
  PathField(const CellMap& map, const std::vector<std::uint8_t>& passable,
            const geometry::Vec2& start_map_m, double escape_m = 1.0);

  /// Length of the path [m]; infinite if there is none.
  [[nodiscard]] double length_m(const CellMap::Cell& to) const;

  /// The path from the start as its corners, joined by straight lines over passable cells. Empty if
  /// there is none.
  [[nodiscard]] std::vector<geometry::Vec2> path_to(const CellMap::Cell& to) const;

 private:
  void flood(std::size_t start);
  [[nodiscard]] bool sees(const CellMap::Cell& a, const CellMap::Cell& b) const;

  const CellMap* map_;
  const std::vector<std::uint8_t>* passable_;
  std::vector<float> length_m_;
  std::vector<std::uint8_t> from_;  ///< direction of the step into each cell; 8: start or none
};

/// Probability of line of sight between two positions (algorithms_fleet 10.3, P_los): 0 with an
/// obstacle between them, 0.5 with unknown space, else 1. Obstacles within 0.5 m of the ends are
/// the vehicles themselves.
[[nodiscard]] double sight_fraction(const CellMap& map, const geometry::Vec2& from_map_m,
                                    const geometry::Vec2& to_map_m);

}  // namespace rali::map
