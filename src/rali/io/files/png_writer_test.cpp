#include "rali/io/files/png_writer.hpp"

#include <gtest/gtest.h>
#include <png.h>

namespace rali::io {
namespace {

/// Three bytes per pixel, read by libpng.
std::vector<std::uint8_t> pixels_of(const std::vector<std::byte>& bytes) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()), 0) << png.message;
  EXPECT_NE(png.format & PNG_FORMAT_FLAG_COLORMAP, 0U) << "a palette, not three bytes per pixel";
  png.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> pixels(PNG_IMAGE_SIZE(png));
  EXPECT_NE(png_image_finish_read(&png, nullptr, pixels.data(), 0, nullptr), 0) << png.message;
  return pixels;
}

TEST(PngWriter, every_colour_of_a_full_palette_comes_back_where_it_was) {
  IndexedImage image;
  image.width = 60;
  image.height = 7;
  for (int c = 0; c < 256; ++c) {
    image.palette.push_back({static_cast<std::uint8_t>(c), static_cast<std::uint8_t>(255 - c),
                             static_cast<std::uint8_t>(c * 7)});
  }
  std::vector<std::uint8_t> expected;
  for (unsigned i = 0; i < 60 * 7; ++i) {
    image.index.push_back(static_cast<std::uint8_t>(i * 37));
    const auto& colour = image.palette[image.index.back()];
    expected.insert(expected.end(), colour.begin(), colour.end());
  }
  EXPECT_EQ(pixels_of(png_bytes(image)), expected);
}

TEST(PngWriter, a_blank_sheet_takes_little_room) {
  IndexedImage image;
  image.width = image.height = 1000;
  image.palette = {{255, 255, 255}, {1, 2, 3}};
  image.index.resize(1'000'000);
  const std::vector<std::byte> bytes = png_bytes(image);
  EXPECT_LT(bytes.size(), 3'000U);
  EXPECT_EQ(bytes, png_bytes(image));
}

}  // namespace
}  // namespace rali::io
