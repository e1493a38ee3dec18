#include "rali/io/files/png_writer.hpp"

#include <algorithm>
#include <span>
#include <string_view>

#include <fmt/format.h>

#include "rali/io/containers/crc32.hpp"
#include "rali/io/files/atomic_file.hpp"

namespace rali::io {
namespace {

using Bytes = std::vector<std::byte>;

constexpr std::size_t kPixelBytes = 3;
// Lengths of a match in RFC 1951.
constexpr std::size_t kMatchMin = 3, kMatchMax = 258;

void put_u32(Bytes& out, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) out.push_back(std::byte(value >> shift & 0xff));
}

void put_chunk(Bytes& out, std::string_view name, const Bytes& data) {
  put_u32(out, static_cast<std::uint32_t>(data.size()));
  Bytes body;
  body.reserve(name.size() + data.size());
  for (const char c : name) body.push_back(std::byte(c));
  body.insert(body.end(), data.begin(), data.end());
  out.insert(out.end(), body.begin(), body.end());
  put_u32(out, crc32(body));
}

/// Adler-32 of RFC 1950.
std::uint32_t adler32(std::span<const std::uint8_t> bytes) {
  constexpr std::uint32_t kModulus = 65521;
  std::uint32_t a = 1, b = 0;
  for (const std::uint8_t byte : bytes) {
    a = (a + byte) % kModulus;
    b = (b + a) % kModulus;
  }
  return b << 16 | a;
}

/// Writes one block with the fixed codes of RFC 1951, section 3.2.6.
class FixedDeflate {
 public:
  FixedDeflate(Bytes& out, std::size_t pixel_bytes) : out_(out), pixel_bytes_(pixel_bytes) {
    bits(1, 1);  // last block
    bits(1, 2);  // fixed codes
  }

  void literal(std::uint8_t value) {
    if (value < 144) {
      code(0x30U + value, 8);
    } else {
      code(0x190U + value - 144U, 9);
    }
  }

  /// `length` bytes equal to those one pixel before.
  void match(std::size_t length) {
    length_symbol(length);
    code(static_cast<std::uint32_t>(pixel_bytes_ - 1), 5);  // distances 1 to 4: symbols 0 to 3
  }

  void end() {
    code(0, 7);
    if (filled_ > 0) bits(0, 8 - filled_);
  }

 private:
  void length_symbol(std::size_t length) {
    if (length == kMatchMax) return symbol(285);
    const auto rest = static_cast<std::uint32_t>(length - kMatchMin);
    if (rest < 8) return symbol(257 + rest);
    int extra = 1;
    while (rest >= 8U << extra) ++extra;
    const std::uint32_t high = rest >> extra;  // 4 to 7
    symbol(257 + 4 * static_cast<std::uint32_t>(extra) + high);
    bits(rest & ((1U << extra) - 1U), extra);
  }

  void symbol(std::uint32_t value) {
    if (value < 280) {
      code(value - 256, 7);
    } else {
      code(0xC0U + value - 280, 8);
    }
  }

  /// Huffman codes go out from their highest bit, all else from the lowest.
  void code(std::uint32_t value, int count) {
    for (int i = count - 1; i >= 0; --i) bits(value >> i & 1U, 1);
  }

  void bits(std::uint32_t value, int count) {
    for (int i = 0; i < count; ++i) {
      pending_ |= (value >> i & 1U) << filled_;
      if (++filled_ < 8) continue;
      out_.push_back(std::byte(pending_));
      pending_ = 0;
      filled_ = 0;
    }
  }

  Bytes& out_;
  std::size_t pixel_bytes_;
  std::uint32_t pending_ = 0;
  int filled_ = 0;
};

Bytes zlib_stream(std::span<const std::uint8_t> raw, std::size_t pixel_bytes) {
  Bytes out = {std::byte{0x78}, std::byte{0x01}};
  FixedDeflate deflate(out, pixel_bytes);
  std::size_t at = 0;
  while (at < raw.size()) {
    std::size_t run = 0;
    const std::size_t limit = std::min(kMatchMax, raw.size() - at);
    while (at >= pixel_bytes && run < limit && raw[at + run] == raw[at + run - pixel_bytes]) ++run;
    if (run >= kMatchMin) {
      deflate.match(run);
      at += run;
    } else {
      deflate.literal(raw[at++]);
    }
  }
  deflate.end();
  put_u32(out, adler32(raw));
  return out;
}

/// Rows with the filter byte 0 (none) before each.
std::vector<std::uint8_t> rows_of(const std::vector<std::uint8_t>& bytes, std::size_t row,
                                  std::size_t height) {
  std::vector<std::uint8_t> raw;
  raw.reserve((row + 1) * height);
  for (std::size_t y = 0; y < height; ++y) {
    raw.push_back(0);
    const auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(y * row);
    raw.insert(raw.end(), begin, begin + static_cast<std::ptrdiff_t>(row));
  }
  return raw;
}

/// Signature and IHDR. @param colour_type 2: RGB, 3: palette.
Bytes png_begin(std::uint32_t width, std::uint32_t height, int colour_type) {
  Bytes out;
  for (const int c : {0x89, 0x50, 0x4E, 0x47, 0x0D, 0x0A, 0x1A, 0x0A}) out.push_back(std::byte(c));
  Bytes header;
  put_u32(header, width);
  put_u32(header, height);
  for (const int c : {8, colour_type, 0, 0, 0}) header.push_back(std::byte(c));
  put_chunk(out, "IHDR", header);
  return out;
}

}  // namespace

Bytes png_bytes(const RgbImage& image) {
  Bytes out = png_begin(image.width, image.height, 2);
  const auto raw = rows_of(image.rgb, kPixelBytes * image.width, image.height);
  put_chunk(out, "IDAT", zlib_stream(raw, kPixelBytes));
  put_chunk(out, "IEND", {});
  return out;
}

Bytes png_bytes(const IndexedImage& image) {
  Bytes out = png_begin(image.width, image.height, 3);
  Bytes palette;
  for (const auto& colour : image.palette) {
    for (const std::uint8_t channel : colour) palette.push_back(std::byte{channel});
  }
  put_chunk(out, "PLTE", palette);
  put_chunk(out, "IDAT", zlib_stream(rows_of(image.index, image.width, image.height), 1));
  put_chunk(out, "IEND", {});
  return out;
}

Status write_png(const std::string& path, const RgbImage& image) {
  const std::size_t pixels = std::size_t{image.width} * image.height;
  if (pixels == 0 || image.rgb.size() != kPixelBytes * pixels) {
    return fail(ErrorCode::kUsage, path,
                fmt::format("an image of {} x {} pixels does not have {} bytes", image.width,
                            image.height, image.rgb.size()));
  }
  return write_file_atomic(path, std::span<const std::byte>(png_bytes(image)));
}

}  // namespace rali::io
