#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace rali::io {

/// Rows from the top, one byte per pixel that names a colour of the palette.
struct IndexedImage {
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint8_t> index;                   ///< width * height
  std::vector<std::array<std::uint8_t, 3>> palette;  ///< at most 256 colours, all that are named
};

/// A PNG with a palette. The image has pixels, and as many as its size says.
[[nodiscard]] std::vector<std::byte> png_bytes(const IndexedImage& image);

}  // namespace rali::io
