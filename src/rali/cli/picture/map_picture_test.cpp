#include "rali/cli/picture/map_picture.hpp"

#include <cmath>
#include <filesystem>
#include <limits>

#include <gtest/gtest.h>
#include <png.h>

#include "rali/cli/command.hpp"
#include "rali/cli/picture/colours.hpp"
#include "rali/cli/picture/height_layers.hpp"
#include "rali/cli/picture/legend.hpp"
#include "rali/cli/run_for_test.hpp"
#include "rali/io/files/test_folder.hpp"

namespace rali::cli {
namespace {

using Bytes = std::vector<std::byte>;

struct Pixels {
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint8_t> rgb;

  [[nodiscard]] bool is(std::uint32_t x, std::uint32_t y, Colour c) const {
    const std::uint8_t* p = rgb.data() + 3 * (std::size_t{y} * width + x);
    return p[0] == c.r && p[1] == c.g && p[2] == c.b;
  }
};

Pixels pixels_of(const Bytes& png) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_memory(&image, png.data(), png.size()), 0) << image.message;
  image.format = PNG_FORMAT_RGB;
  Pixels out{image.width, image.height, std::vector<std::uint8_t>(PNG_IMAGE_SIZE(image))};
  EXPECT_NE(png_image_finish_read(&image, nullptr, out.rgb.data(), 0, nullptr), 0);
  return out;
}

/// Columns from the first to the last pixel of this colour in rows [top, bottom).
std::uint32_t columns_of(const Pixels& image, Colour colour, std::uint32_t top,
                         std::uint32_t bottom) {
  std::uint32_t first = image.width, last = 0;
  for (std::uint32_t y = top; y < bottom; ++y) {
    for (std::uint32_t x = 0; x < image.width; ++x) {
      if (!image.is(x, y, colour)) continue;
      first = std::min(first, x);
      last = std::max(last, x + 1);
    }
  }
  return last > first ? last - first : 0;
}

/// A wall along x, 20 m long and 2 m high, and a trajectory beside it.
MapPicture wall(double end_m = 20.0) {
  MapPicture picture;
  picture.caption = "Wall";
  for (int i = 0; i <= 400; ++i) {
    for (int k = 0; k <= 40; ++k) {
      picture.x_m.push_back(0.05F * static_cast<float>(i));
      picture.y_m.push_back(0.0F);
      picture.z_m.push_back(0.05F * static_cast<float>(k));
    }
  }
  picture.trajectories.push_back({"v1", false, {{0.0, -4.0, 0.0}, {end_m, -4.0, 0.0}}});
  return picture;
}

TEST(HeightLayers, a_wall_has_high_strength_and_a_floor_with_ceiling_low) {
  HeightLayers layers(3, 1, 0.0, 3.0);
  for (double z = 0.0; z < 3.0; z += 0.05) layers.add(0, 0, z);
  layers.add(1, 0, 0.02);
  layers.add(1, 0, 2.95);
  EXPECT_EQ(layers.strength(0, 0), 1.0);
  EXPECT_GT(layers.fraction(0, 0), 0.95);
  EXPECT_LT(layers.strength(1, 0), 0.3);
  EXPECT_LT(layers.fraction(1, 0), 0.05) << "the floor is shown, not the ceiling";
  EXPECT_EQ(layers.strength(2, 0), 0.0);
}

TEST(HeightLayers, outlier_points_are_ignored_or_clamped) {
  HeightLayers layers(2, 2, 0.0, 0.0);
  layers.add(-1, 0, 0.0);
  layers.add(2, 0, 0.0);
  layers.add(0, 0, std::nan(""));
  EXPECT_EQ(layers.strength(0, 0), 0.0);
  layers.add(0, 0, 1e30);
  layers.add(1, 1, -1e30);
  EXPECT_LE(layers.fraction(0, 0), 1.0);
  EXPECT_GE(layers.fraction(1, 1), 0.0);
}

/// CIE L*a*b* of linear RGB, D65.
std::array<double, 3> lab_of(const std::array<double, 3>& rgb) {
  const auto f = [](double t) { return t > 0.008856 ? std::cbrt(t) : 7.787 * t + 16.0 / 116.0; };
  const double x = f((0.4124 * rgb[0] + 0.3576 * rgb[1] + 0.1805 * rgb[2]) / 0.9505);
  const double y = f(0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]);
  const double z = f((0.0193 * rgb[0] + 0.1192 * rgb[1] + 0.9505 * rgb[2]) / 1.089);
  return {116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)};
}

using Matrix = std::array<std::array<double, 3>, 3>;
constexpr Matrix kSeesAll = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
// G. Machado et al., A Physiologically-based Model for Simulation of Color Vision Deficiency
// (2009).
constexpr Matrix kNoRed = {{{0.152286, 1.052583, -0.204868},
                            {0.114503, 0.786281, 0.099216},
                            {-0.003882, -0.048116, 1.051998}}};
constexpr Matrix kNoGreen = {{{0.367322, 0.860646, -0.227968},
                              {0.280085, 0.672501, 0.047413},
                              {-0.011820, 0.042940, 0.968881}}};

std::array<double, 3> seen(Colour colour, const Matrix& vision) {
  const auto linear = [](double v) {
    return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
  };
  const std::array<double, 3> rgb = {linear(colour.r / 255.0), linear(colour.g / 255.0),
                                     linear(colour.b / 255.0)};
  std::array<double, 3> out{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) out[i] += vision[i][k] * rgb[k];
    out[i] = std::clamp(out[i], 0.0, 1.0);
  }
  return lab_of(out);
}

TEST(Colours, of_truth_and_trajectories_differ_with_colour_blindness) {
  std::vector<Colour> colours{kTruthColour};
  for (std::size_t i = 0; i < kTrajectoryColours; ++i) colours.push_back(trajectory_colour(i));
  for (const Matrix& vision : {kSeesAll, kNoRed, kNoGreen}) {
    for (std::size_t i = 0; i < colours.size(); ++i) {
      for (std::size_t k = i + 1; k < colours.size(); ++k) {
        const auto a = seen(colours[i], vision), b = seen(colours[k], vision);
        EXPECT_GT(std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]), 20.0) << i << ' ' << k;
      }
    }
  }
}

TEST(Colours, of_heights_get_darker_with_height) {
  for (int i = 0; i < 50; ++i) {
    EXPECT_GT(seen(height_colour(i / 50.0), kSeesAll)[0],
              seen(height_colour((i + 1) / 50.0), kSeesAll)[0] + 0.2);
  }
  EXPECT_EQ(height_colour(std::nan("")).r, height_colour(0.0).r);
}

TEST(Layout, a_600_m_long_3_m_wide_tunnel_is_split_into_strips) {
  const Layout one = choose_layout({600.0, {300.0}, 20.0}, 500.0);
  EXPECT_EQ(one.strips, 1U);
  const Layout cut = choose_layout({600.0, {3.0}, 20.0}, 500.0);
  EXPECT_GT(cut.strips, 1U);
  EXPECT_GE(3.0 * cut.pt_per_m, 8.0) << "thinner than 3 mm";
  EXPECT_LE(600.0 * cut.pt_per_m / static_cast<double>(cut.strips), 500.0);
}

TEST(Layout, square_maps_are_side_by_side_and_long_maps_are_stacked) {
  EXPECT_EQ(choose_layout({50.0, {50.0, 50.0}, 20.0}, 500.0).columns, 2U);
  EXPECT_EQ(choose_layout({150.0, {10.0, 10.0}, 20.0}, 500.0).columns, 1U);
}

TEST(Layout, scale_bar_lengths_are_round_numbers) {
  EXPECT_EQ(scale_bar_m(7.3), 5.0);
  EXPECT_EQ(scale_bar_m(49.0), 20.0);
  EXPECT_EQ(scale_bar_m(1.0), 1.0);
  EXPECT_NEAR(scale_bar_m(0.3), 0.2, 1e-12);
  EXPECT_EQ(scale_bar_m(std::nan("")), 1.0);
}

TEST(Layout, texts_are_wrapped_and_long_words_shortened) {
  const TextWidth count = [](std::string_view text) { return static_cast<double>(text.size()); };
  EXPECT_EQ(wrapped("one two  three", 7.0, count), (std::vector<std::string>{"one two", "three"}));
  EXPECT_EQ(wrapped("abcdefghij k", 6.0, count), (std::vector<std::string>{"abc...", "k"}));
  EXPECT_EQ(shortened("ab\xC3\xA9xyz", 6.0, count), "ab...") << "no half of a character";
  EXPECT_TRUE(wrapped("", 5.0, count).empty());
}

TEST(Legend, items_neither_overlap_nor_leave_the_page) {
  MapPicture picture = wall();
  picture.trajectories.clear();
  picture.trajectories.push_back({"truth", true, {{0, 0, 0}}});
  for (int i = 0; i < 10; ++i) {
    picture.trajectories.push_back(
        {"a vehicle with a rather long name " + std::to_string(i), false, {{0, 0, 0}}});
  }
  Sheet measure(1.0, 1.0, PictureFormat::kPng);
  for (const double width_mm : {kOneColumn_mm, kTwoColumns_mm}) {
    const double width = width_mm * kPointsPerMm;
    Legend legend({picture}, {0.0, 3.0});
    legend.set_map({false, {0.0, 20.0}, {0.0, 5.0}, width / 20.0, 1}, width);
    const std::vector<Legend::Place> places = legend.places(width, measure);
    ASSERT_EQ(places.size(), 13U);
    for (std::size_t i = 0; i < places.size(); ++i) {
      EXPECT_LE(places[i].x + places[i].width, width);
      EXPECT_GT(places[i].y, 0.0) << "scale and heights fill the first row";
      for (std::size_t k = 0; k < i; ++k) {
        if (places[k].y != places[i].y) continue;
        EXPECT_LE(places[k].x + places[k].width, places[i].x);
      }
    }
    EXPECT_GT(legend.height_pt(width, measure), places.back().y);
  }
}

TEST(MapPicture, has_the_requested_width_and_a_horizontal_long_side) {
  const auto png = draw_maps({wall()}, {"", kOneColumn_mm, PictureFormat::kPng});
  ASSERT_TRUE(png);
  const Pixels image = pixels_of(*png);
  EXPECT_NEAR(image.width, 88.0 / 25.4 * 300.0, 1.0);
  EXPECT_GT(image.width, image.height);
  EXPECT_GT(columns_of(image, trajectory_colour(0), 0, image.height / 2), image.width * 9 / 10);
  MapPicture upright = wall();
  std::swap(upright.x_m, upright.y_m);
  upright.trajectories[0].points_map_m = {{4.0, 0.0, 0.0}, {4.0, 20.0, 0.0}};
  const Pixels turned = pixels_of(*draw_maps({upright}, {"", kOneColumn_mm, PictureFormat::kPng}));
  EXPECT_EQ(turned.width, image.width);
  EXPECT_GT(turned.width, turned.height);
}

TEST(MapPicture, panels_share_one_scale) {
  const Pixels image = pixels_of(*draw_maps({wall(), wall(10.0)}, {}));
  const Colour colour = trajectory_colour(0);
  const std::uint32_t half = image.height / 2;
  const double whole = columns_of(image, colour, 0, half);
  const double part = columns_of(image, colour, half, image.height * 7 / 8);
  EXPECT_GT(part, 500.0);
  EXPECT_NEAR(whole, 2.0 * part, 40.0) << "20 m above, 10 m below";
}

TEST(MapPicture, ground_truth_is_visible_on_both_sides_of_the_trajectory) {
  MapPicture picture = wall();
  picture.trajectories.push_back({"truth", true, picture.trajectories[0].points_map_m});
  const Pixels image = pixels_of(*draw_maps({picture}, {}));
  const std::uint32_t x = image.width / 2;
  std::vector<char> column;  // which of the two, from the top
  for (std::uint32_t y = 0; y < image.height * 5 / 6; ++y) {
    const char c = image.is(x, y, kTruthColour)           ? 't'
                   : image.is(x, y, trajectory_colour(0)) ? 'v'
                                                          : ' ';
    if (c != ' ' && (column.empty() || column.back() != c)) column.push_back(c);
  }
  EXPECT_EQ(column, (std::vector<char>{'t', 'v', 't'}));
}

TEST(MapPicture, the_same_input_gives_the_same_bytes_in_every_format) {
  const std::vector<std::pair<PictureFormat, std::string>> formats = {
      {PictureFormat::kPng, "\x89PNG"}, {PictureFormat::kPdf, "%PDF"}};
  for (const auto& [format, magic] : formats) {
    const auto once = draw_maps({wall(), wall()}, {"Title", 120.0, format});
    const auto again = draw_maps({wall(), wall()}, {"Title", 120.0, format});
    ASSERT_TRUE(once && again);
    EXPECT_EQ(*once, *again);
    const std::string text(reinterpret_cast<const char*>(once->data()), once->size());
    EXPECT_TRUE(text.starts_with(magic));
    EXPECT_EQ(text.find("CreationDate"), std::string::npos);
  }
  const auto svg = draw_maps({wall()}, {"", 120.0, PictureFormat::kSvg});
  ASSERT_TRUE(svg);
  EXPECT_NE(std::string(reinterpret_cast<const char*>(svg->data()), 200).find("<svg"),
            std::string::npos);
}

TEST(MapPicture, stays_small_with_huge_or_nan_points_and_refuses_empty_maps) {
  MapPicture picture = wall();
  picture.x_m[5] = 1e30F;
  picture.y_m[9] = std::numeric_limits<float>::infinity();
  picture.z_m[3] = std::nanf("");
  picture.trajectories[0].points_map_m.push_back({std::nan(""), 0.0, 0.0});
  picture.trajectories.push_back({"\xFF\x01 v2", false, {{3.0, -1.0, 0.0}}});
  const auto png = draw_maps({picture}, {"a title \xC3", kTwoColumns_mm, PictureFormat::kPng});
  ASSERT_TRUE(png);
  EXPECT_LT(pixels_of(*png).height, 2000U);
  EXPECT_FALSE(draw_maps({MapPicture{}}, {}));
  EXPECT_FALSE(draw_maps({}, {}));
  EXPECT_FALSE(draw_maps({wall()}, {"", std::nan(""), PictureFormat::kPng}));
}

TEST(MapPicture, invalid_characters_in_texts_are_replaced_before_drawing) {
  EXPECT_EQ(drawable("tunnel \xC3\xA9 \xE2\x82\xAC"), "tunnel \xC3\xA9 \xE2\x82\xAC");
  EXPECT_EQ(drawable("a\xFF\xC3(\x1B[0m\xED\xA0\x80"), std::string("a?") + "?(?[0m???");
  EXPECT_EQ(missing_font(), "") << "packages.txt installs fonts-dejavu-core";
}

/// A cloud and trajectories of 3 m and of zero length, as `rali map` writes them.
std::string small_run(const io::TestFolder& folder) {
  std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 50\nproperty float x\n"
      "property float y\nproperty float z\nend_header\n";
  for (int i = 0; i < 50; ++i) ply += std::to_string(0.1 * i) + " 0 0.5\n";
  std::filesystem::create_directories(folder.path("run/trajectory"));
  folder.write("run/map.ply", ply);
  folder.write("run/trajectory/v1.tum", "1 2 1 0 0 0 0 1\n2 2.01 1 0 0 0 0 1\n");
  folder.write("run/trajectory/v2.tum", "1 0 1 0 0 0 0 1\n2 3 1 0 0 0 0 1\n");
  return folder.path("run");
}

TEST(MapPicture, caption_without_truth_gives_distances_travelled_and_standing_vehicles) {
  const io::TestFolder folder;
  const auto picture = picture_of_folder(small_run(folder));
  ASSERT_TRUE(picture) << picture.error().message();
  EXPECT_EQ(picture->caption, "v1 stands, v2 travelled 3.0 m");
}

TEST(MapPicture, a_folder_without_a_map_is_refused_by_name) {
  const auto picture = picture_of_folder("/there/is/none");
  ASSERT_FALSE(picture);
  EXPECT_NE(picture.error().message().find("/there/is/none/map.pcd"), std::string::npos);
}

TEST(PictureCommand, writes_the_format_of_the_file_extension) {
  const io::TestFolder folder;
  const std::string run = small_run(folder);
  for (const char* name : {"a.png", "a.pdf", "a.svg"}) {
    ASSERT_EQ(run_rali({"picture", run, "-o", folder.path(name), "--width", "88"}).code, kExitDone);
    EXPECT_GT(folder.read(name).size(), 500U);
  }
  const Outcome odd = run_rali({"picture", run, "-o", folder.path("a.jpg")});
  EXPECT_EQ(odd.code, kExitNotStarted);
  EXPECT_NE(odd.err.find("ends in .png, .pdf or .svg"), std::string::npos) << odd.err;
  const Outcome narrow = run_rali({"picture", run, "--width", "5"});
  EXPECT_EQ(narrow.code, kExitNotStarted);
  EXPECT_NE(narrow.err.find("60 to 420 mm"), std::string::npos) << narrow.err;
}

}  // namespace
}  // namespace rali::cli
