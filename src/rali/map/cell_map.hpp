#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "rali/geometry/types.hpp"

namespace rali::map {

enum class CellState : std::uint8_t { kUnknown, kFree, kOccupied };

/// A snapshot of a grid: cells row by row from the bottom (smallest y). All outside is unknown.
struct CellMap {
  double cell_m = 0.2;
  geometry::Vec2 origin_map_m = geometry::Vec2::Zero();  ///< corner of the lower-left cell
  int width = 0, height = 0;
  std::vector<CellState> cells;

  struct Cell {
    int x = 0, y = 0;
    bool operator==(const Cell&) const = default;
  };

  [[nodiscard]] bool holds(const Cell& c) const {
    return c.x >= 0 && c.y >= 0 && c.x < width && c.y < height;
  }

  [[nodiscard]] std::size_t index(const Cell& c) const {
    return static_cast<std::size_t>(c.y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(c.x);
  }

  [[nodiscard]] Cell cell(std::size_t index) const {
    const auto w = static_cast<std::size_t>(width);
    return {static_cast<int>(index % w), static_cast<int>(index / w)};
  }

  [[nodiscard]] CellState at(const Cell& c) const {
    return holds(c) ? cells[index(c)] : CellState::kUnknown;
  }

  /// The cell of a position; one outside is clamped to two cells beside the map.
  [[nodiscard]] Cell cell_at(const geometry::Vec2& p_map_m) const;
  [[nodiscard]] geometry::Vec2 centre_m(const Cell& c) const;
};

}  // namespace rali::map
