#include "rali/io/files/grid_file.hpp"

#include <filesystem>
#include <vector>

#include <fmt/core.h>

#include "rali/base/assert.hpp"
#include "rali/io/files/atomic_file.hpp"
#include "rali/io/files/text.hpp"

namespace rali::io {
namespace {

std::byte grey(GridCell cell) {
  switch (cell) {
    case GridCell::kFree:
      return std::byte{254};
    case GridCell::kOccupied:
      return std::byte{0};
    case GridCell::kUnknown:
      break;
  }
  return std::byte{205};
}

Status write_pgm(const std::string& path, const GridView& grid) {
  auto file = AtomicFile::create(path);
  if (!file) return tl::make_unexpected(file.error());
  const std::string header = fmt::format("P5\n{} {}\n255\n", grid.width, grid.height);
  if (auto status = file->write(std::string_view(header)); !status) return status;
  std::vector<std::byte> line(grid.width);
  for (std::size_t row = grid.height; row-- > 0;) {
    const auto cells = grid.cells.subspan(row * grid.width, grid.width);
    for (std::size_t i = 0; i < line.size(); ++i) line[i] = grey(cells[i]);
    if (auto status = file->write(line); !status) return status;
  }
  return file->commit();
}

}  // namespace

Status write_grid(const std::string& stem, const GridView& grid) {
  RALI_ASSERT(grid.cells.size() == std::size_t{grid.width} * grid.height);
  if (auto status = write_pgm(stem + ".pgm", grid); !status) return status;
  // free_thresh: with Nav2's default 0.25 the grey of unknown would load as free.
  const std::string yaml = fmt::format(
      "image: {}.pgm\nmode: trinary\nresolution: {}\norigin: [{}, {}, 0]\nnegate: 0\n"
      "occupied_thresh: 0.65\nfree_thresh: 0.196\n",
      std::filesystem::path(stem).filename().string(), format_fixed(grid.cell_m, 6),
      format_fixed(grid.origin_x_m, 6), format_fixed(grid.origin_y_m, 6));
  return write_file_atomic(stem + ".yaml", std::string_view(yaml));
}

}  // namespace rali::io
