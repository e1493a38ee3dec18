#include "rali/cli/picture/map_picture.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "rali/cli/picture/height_layers.hpp"
#include "rali/cli/picture/stroke_font.hpp"

namespace rali::cli {
namespace {

constexpr Colour kWhite{255, 255, 255}, kBlack{0, 0, 0};

int red_at(const Canvas& canvas, std::uint32_t x, std::uint32_t y) {
  return canvas.image().rgb[3 * (std::size_t{y} * canvas.image().width + x)];
}

TEST(Canvas, a_line_covers_its_width_and_softens_its_edge) {
  Canvas canvas(20, 20, kWhite);
  canvas.line(5.0, 10.0, 15.0, 10.0, 3.0, kBlack);
  EXPECT_EQ(red_at(canvas, 10, 10), 0);
  EXPECT_EQ(red_at(canvas, 10, 9), 0);
  EXPECT_EQ(red_at(canvas, 10, 12), 255);
  Canvas soft(20, 20, kWhite);
  soft.line(5.0, 10.5, 15.0, 10.5, 2.0, kBlack);
  EXPECT_EQ(red_at(soft, 10, 10), 0);
  EXPECT_EQ(red_at(soft, 10, 9), 255);
  EXPECT_EQ(red_at(soft, 10, 12), 255);
  soft.line(5.0, 4.0, 15.0, 4.0, 2.0, kBlack);
  EXPECT_EQ(red_at(soft, 10, 5), 128) << "half covered";
}

TEST(Canvas, what_lies_outside_or_is_no_number_is_left_out) {
  Canvas canvas(8, 8, kWhite);
  canvas.line(-1e12, 3.0, 1e12, 3.0, 1.0, kBlack);
  EXPECT_EQ(red_at(canvas, 0, 3), 0);
  EXPECT_EQ(red_at(canvas, 7, 3), 0);
  const std::vector<std::uint8_t> before = canvas.image().rgb;
  canvas.line(-50.0, -50.0, -10.0, -10.0, 5.0, kBlack);
  canvas.line(std::nan(""), 0.0, 5.0, 5.0, 2.0, kBlack);
  canvas.rectangle(-5, -5, 3, 3, kBlack);
  canvas.text(100.0, 100.0, 10.0, "far", kBlack);
  EXPECT_EQ(canvas.image().rgb, before);
}

TEST(Canvas, text_ends_where_its_width_says) {
  Canvas canvas(400, 60, kWhite);
  const double end = canvas.text(10.0, 40.0, 24.0, "Map 1.5 m", kBlack);
  EXPECT_NEAR(end - 10.0, Canvas::text_width(24.0, "Map 1.5 m") + 1.5 * 24.0 / 6.0, 1e-9);
  EXPECT_EQ(Canvas::text_width(24.0, ""), 0.0);
  EXPECT_EQ(Canvas::text_width(6.0, "\xff"), 3.0) << "a box for what is no character";
}

TEST(StrokeFont, every_printable_character_is_well_formed) {
  for (int c = ' '; c <= '~'; ++c) {
    const std::string_view strokes = strokes_of(static_cast<char>(c));
    for (std::size_t i = 0; i < strokes.size(); ++i) {
      const char s = strokes[i];
      if (i % 3 == 2) {
        EXPECT_TRUE(s == ' ' || s == '|') << static_cast<char>(c);
      } else {
        EXPECT_TRUE(s >= '0' && s <= '8') << static_cast<char>(c);
      }
    }
    EXPECT_EQ(strokes.empty() ? 2U : strokes.size() % 3, 2U) << static_cast<char>(c);
  }
}

TEST(HeightLayers, a_wall_is_strong_and_a_floor_below_a_ceiling_is_not) {
  HeightLayers layers(3, 1, 0.0, 3.0);
  for (double z = 0.0; z < 3.0; z += 0.05) layers.add(0, 0, z);
  layers.add(1, 0, 0.02);
  layers.add(1, 0, 2.95);
  EXPECT_EQ(layers.strength(0, 0), 1.0);
  EXPECT_GT(layers.share(0, 0), 0.95);
  EXPECT_LT(layers.strength(1, 0), 0.3);
  EXPECT_LT(layers.share(1, 0), 0.05) << "the floor is shown, not the ceiling";
  EXPECT_EQ(layers.strength(2, 0), 0.0);
}

TEST(HeightLayers, strays_do_no_harm) {
  HeightLayers layers(2, 2, 0.0, 0.0);
  layers.add(-1, 0, 0.0);
  layers.add(2, 0, 0.0);
  layers.add(0, 0, std::nan(""));
  EXPECT_EQ(layers.strength(0, 0), 0.0);
  layers.add(0, 0, 1e30);
  layers.add(1, 1, -1e30);
  EXPECT_LE(layers.share(0, 0), 1.0);
  EXPECT_GE(layers.share(1, 1), 0.0);
}

TEST(MapPicture, scale_bars_are_round) {
  EXPECT_EQ(scale_bar_m(7.3), 5.0);
  EXPECT_EQ(scale_bar_m(49.0), 20.0);
  EXPECT_EQ(scale_bar_m(1.0), 1.0);
  EXPECT_NEAR(scale_bar_m(0.3), 0.2, 1e-12);
  EXPECT_EQ(scale_bar_m(std::nan("")), 1.0);
}

/// A wall along x, 20 m long and 2 m high, and a way beside it.
MapPicture wall() {
  MapPicture picture;
  picture.title = "Wall";
  for (int i = 0; i <= 400; ++i) {
    for (int k = 0; k <= 40; ++k) {
      picture.x_m.push_back(0.05F * static_cast<float>(i));
      picture.y_m.push_back(0.0F);
      picture.z_m.push_back(0.05F * static_cast<float>(k));
    }
  }
  picture.ways.push_back({"v1", Colour{255, 0, 0}, 4.0, {{0.0, -4.0, 0.0}, {20.0, -4.0, 0.0}}});
  return picture;
}

std::size_t count_red(const io::RgbImage& image) {
  std::size_t n = 0;
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    n += image.rgb[i] == 255 && image.rgb[i + 1] == 0 && image.rgb[i + 2] == 0;
  }
  return n;
}

TEST(MapPicture, shows_the_wall_above_the_way_and_lays_the_long_side_across) {
  const auto image = draw_map(wall());
  ASSERT_TRUE(image);
  EXPECT_GT(image->width, image->height);
  // 1000 pixels long; of 4 pixels across, 3 at least are covered whole.
  EXPECT_GT(count_red(*image), 3U * 950U);
  MapPicture turned = wall();
  std::swap(turned.x_m, turned.y_m);
  turned.ways[0].points_map_m = {{4.0, 0.0, 0.0}, {4.0, 20.0, 0.0}};
  const auto other = draw_map(turned);
  ASSERT_TRUE(other);
  EXPECT_EQ(other->width, image->width);
  EXPECT_EQ(other->height, image->height);
}

TEST(MapPicture, stays_small_for_points_without_end_and_refuses_none) {
  MapPicture picture = wall();
  picture.x_m[5] = 1e30F;
  picture.y_m[9] = std::numeric_limits<float>::infinity();
  picture.z_m[3] = std::nanf("");
  const auto image = draw_map(picture);
  ASSERT_TRUE(image);
  EXPECT_LT(image->width, 2000U);
  EXPECT_LT(image->height, 2000U);
  EXPECT_FALSE(draw_map(MapPicture{}));
}

TEST(MapPicture, a_folder_without_a_map_is_refused_by_name) {
  const auto picture = picture_of_folder("/there/is/none");
  ASSERT_FALSE(picture);
  EXPECT_NE(picture.error().message().find("/there/is/none/map.pcd"), std::string::npos);
}

}  // namespace
}  // namespace rali::cli
