#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "rali/base/result.hpp"

namespace rali::io {

enum class GridCell : std::uint8_t { kUnknown, kFree, kOccupied };

/// An occupancy grid in the map frame. Cell (column, row) is cells[row * width + column]; row 0 is
/// the one with the smallest y.
struct GridView {
  std::uint32_t width = 0, height = 0;
  double cell_m = 0.05;
  double origin_x_m = 0.0, origin_y_m = 0.0;  ///< corner of cell (0, 0) with the smallest x and y
  std::span<const GridCell> cells;
};

/// `STEM.pgm` (8 bit P5: 254 free, 0 occupied, 205 unknown; first line of the image = largest y)
/// and `STEM.yaml` as Nav2's map_server reads them (product.md section 5).
[[nodiscard]] Status write_grid(const std::string& stem, const GridView& grid);

}  // namespace rali::io
