#include "rali/io/files/png_writer.hpp"

#include <gtest/gtest.h>

#include "rali/io/files/test_folder.hpp"

namespace rali::io {
namespace {

/// Reads what the writer may write: one fixed block with matches at distance 3.
class Inflate {
 public:
  explicit Inflate(std::vector<std::byte> bytes, std::size_t pixel_bytes = 3)
      : bytes_(std::move(bytes)), pixel_bytes_(pixel_bytes) {}

  std::vector<std::uint8_t> run() {
    EXPECT_EQ(bits(3), 3U) << "last block, fixed codes";
    std::vector<std::uint8_t> out;
    for (;;) {
      const std::uint32_t symbol = next_symbol();
      if (symbol == 256 || at_ >= 8 * bytes_.size()) return out;
      if (symbol < 256) {
        out.push_back(static_cast<std::uint8_t>(symbol));
        continue;
      }
      std::size_t length = symbol == 285 ? 258 : 0;
      if (symbol < 265) length = symbol - 254;
      if (length == 0) {
        const std::uint32_t extra = (symbol - 261) / 4;
        length = 3 + ((4 + (symbol - 261) % 4) << extra) + bits(static_cast<int>(extra));
      }
      EXPECT_EQ(reversed(5), pixel_bytes_ - 1) << "one pixel back";
      for (std::size_t i = 0; i < length; ++i) out.push_back(out[out.size() - pixel_bytes_]);
    }
  }

 private:
  std::uint32_t bits(int count) {
    std::uint32_t value = 0;
    for (int i = 0; i < count; ++i, ++at_) {
      const auto byte =
          std::to_integer<std::uint32_t>(bytes_[std::min(at_ / 8, bytes_.size() - 1)]);
      value |= (byte >> (at_ % 8) & 1U) << i;
    }
    return value;
  }

  std::uint32_t reversed(int count) {
    std::uint32_t value = 0;
    for (int i = 0; i < count; ++i) value = value << 1 | bits(1);
    return value;
  }

  std::uint32_t next_symbol() {
    const std::uint32_t seven = reversed(7);
    if (seven < 24) return 256 + seven;
    const std::uint32_t eight = seven << 1 | reversed(1);
    if (eight < 0xC0) return eight - 0x30;
    if (eight < 0xC8) return 280 + eight - 0xC0;
    return 144 + (eight << 1 | reversed(1)) - 0x190;
  }

  std::vector<std::byte> bytes_;
  std::size_t pixel_bytes_;
  std::size_t at_ = 0;
};

std::uint32_t u32_at(const std::vector<std::byte>& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i)
    value = value << 8 | std::to_integer<std::uint32_t>(bytes[at + i]);
  return value;
}

/// The filtered rows of a PNG of this writer: IHDR ends at 33, IDAT's data begin at 41.
std::vector<std::uint8_t> rows_in(const std::vector<std::byte>& png) {
  const std::size_t length = u32_at(png, 33);
  const auto begin = png.begin() + 41 + 2;  // after the head of the zlib stream
  return Inflate({begin, begin + static_cast<std::ptrdiff_t>(length - 6)}).run();
}

RgbImage image_of(std::uint32_t width, std::uint32_t height, std::vector<std::uint8_t> rgb) {
  return {width, height, std::move(rgb)};
}

TEST(Png, one_red_pixel_has_the_bytes_worked_by_hand) {
  const std::vector<std::byte> png = png_bytes(image_of(1, 1, {255, 0, 0}));
  EXPECT_EQ(u32_at(png, 0), 0x89504E47U);
  EXPECT_EQ(u32_at(png, 16), 1U);
  EXPECT_EQ(u32_at(png, 20), 1U);
  EXPECT_EQ(u32_at(png, 29), 0x907753DEU) << "checksum of this header, as in every 1 x 1 RGB PNG";
  EXPECT_EQ(rows_in(png), (std::vector<std::uint8_t>{0, 255, 0, 0}));
  // Adler-32 of 0 255 0 0: a = 256, b = 1 + 256 + 256 + 256 = 769.
  const std::size_t length = u32_at(png, 33);
  EXPECT_EQ(u32_at(png, 41 + length - 4), 769U << 16 | 256U);
}

TEST(Png, runs_of_every_length_come_back) {
  for (std::uint32_t width = 1; width < 400; width += width < 110 ? 1 : 37) {
    std::vector<std::uint8_t> rgb;
    for (std::uint32_t i = 0; i < width; ++i) rgb.insert(rgb.end(), {200, 150, 7});
    const std::vector<std::uint8_t> rows = rows_in(png_bytes(image_of(width, 1, rgb)));
    rgb.insert(rgb.begin(), 0);
    ASSERT_EQ(rows, rgb) << width;
  }
}

TEST(Png, bytes_without_any_pattern_come_back) {
  std::vector<std::uint8_t> rgb;
  std::uint32_t state = 1;
  for (int i = 0; i < 3 * 64 * 48; ++i) {
    state = state * 1664525U + 1013904223U;
    rgb.push_back(static_cast<std::uint8_t>(state >> 24));
  }
  const std::vector<std::uint8_t> rows = rows_in(png_bytes(image_of(64, 48, rgb)));
  ASSERT_EQ(rows.size(), 48U * (1 + 3 * 64));
  for (std::size_t y = 0; y < 48; ++y) {
    ASSERT_EQ(rows[y * 193], 0) << "filter of row " << y;
    for (std::size_t i = 0; i < 192; ++i) ASSERT_EQ(rows[y * 193 + 1 + i], rgb[y * 192 + i]);
  }
}

TEST(Png, a_blank_sheet_takes_little_room) {
  const RgbImage image = image_of(1000, 1000, std::vector<std::uint8_t>(3'000'000, 255));
  EXPECT_LT(png_bytes(image).size(), 30'000U);
}

TEST(Png, refuses_images_whose_bytes_do_not_fit) {
  const TestFolder folder;
  EXPECT_FALSE(write_png(folder.path("a.png"), image_of(2, 2, {1, 2, 3})));
  EXPECT_FALSE(write_png(folder.path("a.png"), image_of(0, 5, {})));
  EXPECT_EQ(folder.files(), 0U);
  EXPECT_TRUE(write_png(folder.path("a.png"), image_of(1, 1, {1, 2, 3})));
}

TEST(PngWriter, writes_a_palette_and_one_byte_per_pixel) {
  IndexedImage image;
  image.width = 5;
  image.height = 2;
  image.palette = {{255, 255, 255}, {1, 2, 3}};
  image.index = {0, 0, 0, 0, 0, 1, 0, 1, 1, 1};
  const std::vector<std::byte> png = png_bytes(image);
  EXPECT_EQ(std::to_integer<int>(png[25]), 3) << "colour type: palette";
  EXPECT_EQ(u32_at(png, 33), 6U) << "length of PLTE";
  EXPECT_EQ(std::to_integer<int>(png[44]), 1);
  EXPECT_EQ(std::to_integer<int>(png[46]), 3);
  const std::size_t idat = 33 + 12 + 6;
  const std::size_t length = u32_at(png, idat);
  const auto begin = png.begin() + static_cast<std::ptrdiff_t>(idat) + 8 + 2;
  const std::vector<std::byte> stream(begin, begin + static_cast<std::ptrdiff_t>(length - 6));
  EXPECT_EQ(Inflate(stream, 1).run(),
            (std::vector<std::uint8_t>{0, 0, 0, 0, 0, 0, 0, 1, 0, 1, 1, 1}));
}

}  // namespace
}  // namespace rali::io
