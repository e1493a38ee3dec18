#pragma once

// A map for planning, for the tests of this folder.

#include <algorithm>
#include <limits>
#include <numeric>
#include <vector>

#include "rali/base/rng.hpp"
#include "rali/fleet/rounds/assignment.hpp"
#include "rali/map/explore_paths.hpp"

namespace rali::fleet::test {

inline VehicleId id(int v) { return VehicleId{static_cast<std::uint16_t>(v)}; }

/// A corridor along x from -5 to 50 m, 3 m wide about y = 0, with a room of 6 x 8 m beside it,
/// 22 < x < 28, 2 < y < 10, behind a door of 2.6 m at x = 25. Beyond its end all is unknown.
inline map::CellMap corridor_with_room() {
  map::CellMap map;
  map.origin_map_m = {-6.0, -3.0};
  map.width = 300;
  map.height = 80;
  map.cells.assign(300 * 80, map::CellState::kUnknown);
  for (std::size_t i = 0; i < map.cells.size(); ++i) {
    const geometry::Vec2 p = map.centre_m(map.cell(i));
    const bool corridor = p.x() > -5.0 && p.x() < 50.0 && std::abs(p.y()) < 1.5;
    const bool room = p.x() > 22.0 && p.x() < 28.0 && p.y() > 2.0 && p.y() < 10.0;
    const bool door = std::abs(p.x() - 25.0) < 1.3 && p.y() > 0.0 && p.y() < 3.0;
    const bool walls = (p.x() < 50.0 && std::abs(p.y()) < 2.0) ||
                       (p.x() > 21.5 && p.x() < 28.5 && p.y() > 0.0 && p.y() < 10.5);
    map.cells[i] = corridor || room || door ? map::CellState::kFree
                   : walls                  ? map::CellState::kOccupied
                                            : map::CellState::kUnknown;
  }
  return map;
}

/// Least cost of assigning as many rows as possible a column each.
inline double least_by_trying(const CostTable& table) {
  const std::size_t n = std::max(table.rows, table.columns);
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  double minimum = std::numeric_limits<double>::infinity();
  do {
    double cost = 0.0;
    for (std::size_t r = 0; r < table.rows; ++r) {
      if (order[r] < table.columns) cost += table.at(r, order[r]);
    }
    minimum = std::min(minimum, cost);
  } while (std::next_permutation(order.begin(), order.end()));
  return minimum;
}

}  // namespace rali::fleet::test
