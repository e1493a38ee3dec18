#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "rali/base/result.hpp"

namespace rali::io {

/// Rows from the top, three bytes per pixel.
struct RgbImage {
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint8_t> rgb;  ///< 3 * width * height

  [[nodiscard]] std::uint8_t* at(std::uint32_t x, std::uint32_t y) {
    return rgb.data() + 3 * (std::size_t{y} * width + x);
  }
};

/// Rows from the top, one byte per pixel that names a colour of the palette.
struct IndexedImage {
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint8_t> index;                   ///< width * height
  std::vector<std::array<std::uint8_t, 3>> palette;  ///< at most 256 colours, all that are named
};

/// A PNG of 8 bits per channel. Only runs of equal pixels are compressed: drawings with one
/// background shrink to a tenth, and no library is needed.
/// Source: PNG, third edition (W3C 2025); RFC 1950, RFC 1951 (fixed codes).
[[nodiscard]] std::vector<std::byte> png_bytes(const RgbImage& image);

/// A PNG with a palette, a third of the size.
[[nodiscard]] std::vector<std::byte> png_bytes(const IndexedImage& image);

/// Errors: kUsage for an image without pixels or with the wrong number of bytes, kMachine.
[[nodiscard]] Status write_png(const std::string& path, const RgbImage& image);

}  // namespace rali::io
