#include "rali/map/range_image.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "rali/map/test_world.hpp"

namespace rali::map {
namespace {

constexpr double kDegree_rad = std::numbers::pi / 180.0;

/// Two lasers, at 0 and -2 degrees, that turn once in steps of 0.2 degrees.
test::Sweep two_rows(double upper_m, double lower_m) {
  test::Sweep sweep;
  for (int i = 0; i < 1800; ++i) {
    const double azimuth = 0.2 * i * kDegree_rad;
    for (int ring = 0; ring < 2; ++ring) {
      const double elevation = ring == 0 ? 0.0 : -2.0 * kDegree_rad;
      const double range_m = ring == 0 ? upper_m : lower_m;
      sweep.add(range_m * std::cos(elevation) * std::cos(azimuth),
                range_m * std::cos(elevation) * std::sin(azimuth), range_m * std::sin(elevation),
                static_cast<std::uint16_t>(ring));
    }
  }
  return sweep;
}

Sight look_5_m_ahead(const test::Sweep& sweep) {
  RangeImage image;
  image.build(sweep.view());
  return image.look({5.0, 0.0, 0.0}, SightLimits{});
}

TEST(RangeImage, a_ray_that_goes_on_behind_has_passed) {
  EXPECT_EQ(look_5_m_ahead(two_rows(10.0, 10.0)), Sight::kPassed);
}

TEST(RangeImage, a_return_from_the_place_is_a_hit) {
  EXPECT_EQ(look_5_m_ahead(two_rows(5.1, 10.0)), Sight::kHit);
}

TEST(RangeImage, a_return_between_hit_and_passage_says_nothing) {
  EXPECT_EQ(look_5_m_ahead(two_rows(5.2, 10.0)), Sight::kUnknown);
}

TEST(RangeImage, the_floor_in_the_next_row_is_neither_hit_nor_passage) {
  // The lower ray ends 5 * 2 deg = 17 cm below the place: not of it, but too near to exclude it.
  EXPECT_EQ(look_5_m_ahead(two_rows(10.0, 4.9)), Sight::kUnknown);
}

TEST(RangeImage, what_stands_before_the_place_hides_it) {
  EXPECT_EQ(look_5_m_ahead(two_rows(3.0, 10.0)), Sight::kUnknown);
}

TEST(RangeImage, rays_farther_apart_than_a_pole_is_thick_prove_nothing) {
  SightLimits limits;
  limits.thin_m = 0.01;  // 5 m * 0.2 deg = 1.7 cm
  RangeImage image;
  image.build(two_rows(10.0, 10.0).view());
  EXPECT_EQ(image.look({5.0, 0.0, 0.0}, limits), Sight::kUnknown);
}

}  // namespace
}  // namespace rali::map
