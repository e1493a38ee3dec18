#include "rali/map/range_image.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "rali/map/test_world.hpp"

namespace rali::map {
namespace {

constexpr double kDegree_rad = std::numbers::pi / 180.0;

/// Two lasers, at 0 and -2 degrees, that turn once in steps of 0.2 degrees.
test::Scan two_rows(double upper_m, double lower_m) {
  test::Scan scan;
  for (int i = 0; i < 1800; ++i) {
    const double azimuth = 0.2 * i * kDegree_rad;
    for (int ring = 0; ring < 2; ++ring) {
      const double elevation = ring == 0 ? 0.0 : -2.0 * kDegree_rad;
      const double range_m = ring == 0 ? upper_m : lower_m;
      scan.add(range_m * std::cos(elevation) * std::cos(azimuth),
               range_m * std::cos(elevation) * std::sin(azimuth), range_m * std::sin(elevation),
               static_cast<std::uint16_t>(ring));
    }
  }
  return scan;
}

Sight look_5_m_ahead(const test::Scan& scan) {
  RangeImage image;
  image.build(scan.view());
  return image.look({5.0, 0.0, 0.0}, SightLimits{});
}

TEST(RangeImage, marks_a_point_passed_when_the_return_is_far_behind_it) {
  EXPECT_EQ(look_5_m_ahead(two_rows(10.0, 10.0)), Sight::kPassed);
}

TEST(RangeImage, marks_a_point_hit_when_the_return_is_near_it) {
  EXPECT_EQ(look_5_m_ahead(two_rows(5.1, 10.0)), Sight::kHit);
}

TEST(RangeImage, marks_a_point_unknown_when_the_return_is_20_cm_behind_it) {
  EXPECT_EQ(look_5_m_ahead(two_rows(5.2, 10.0)), Sight::kUnknown);
}

TEST(RangeImage, marks_a_point_unknown_near_a_floor_return_of_the_next_row) {
  // The lower ray ends 5 * 2 deg = 17 cm below the place: not of it, but too near to exclude it.
  EXPECT_EQ(look_5_m_ahead(two_rows(10.0, 4.9)), Sight::kUnknown);
}

TEST(RangeImage, marks_a_point_unknown_behind_an_occluding_return) {
  EXPECT_EQ(look_5_m_ahead(two_rows(3.0, 10.0)), Sight::kUnknown);
}

TEST(RangeImage, marks_a_point_unknown_when_ray_spacing_exceeds_the_thin_limit) {
  SightLimits limits;
  limits.thin_m = 0.01;  // 5 m * 0.2 deg = 1.7 cm
  RangeImage image;
  image.build(two_rows(10.0, 10.0).view());
  EXPECT_EQ(image.look({5.0, 0.0, 0.0}, limits), Sight::kUnknown);
}

TEST(RangeImage, gives_equal_results_across_the_azimuth_wrap_around) {
  for (const double upper_m : {10.0, 5.1, 5.2, 3.0}) {
    RangeImage image;
    image.build(two_rows(upper_m, 10.0).view());
    const Sight ahead = image.look({5.0, 0.0, 0.0}, SightLimits{});
    for (const double side_m : {-0.03, -0.001, 0.001, 0.03}) {
      EXPECT_EQ(image.look({-5.0, side_m, 0.0}, SightLimits{}), ahead) << upper_m << ' ' << side_m;
    }
  }
}

TEST(RangeImage, may_see_is_false_for_cubes_that_no_ray_reaches) {
  RangeImage image;
  image.build(two_rows(5.0, 5.0).view());
  const SightLimits limits;
  EXPECT_TRUE(image.may_see({5.0, 0.0, 0.0}, 0.5, limits)) << "rays end in it";
  EXPECT_TRUE(image.may_see({-4.0, 0.0, 0.0}, 0.5, limits)) << "rays go through it";
  EXPECT_FALSE(image.may_see({-7.0, 0.0, 0.0}, 0.5, limits)) << "rays end before it";
  EXPECT_FALSE(image.may_see({4.0, 0.0, 3.0}, 0.5, limits)) << "above all rays";
  EXPECT_FALSE(image.may_see({30.0, 0.0, 0.0}, 0.5, limits)) << "beyond the range";
}

TEST(RangeImage, may_see_is_true_for_every_cube_with_an_observed_point) {
  // A window of 20 degrees beside the image's wrap-around, in a wall around the sensor.
  test::Scan scan = two_rows(6.0, 4.0);
  for (std::size_t i = 1750; i < 1850; ++i) {
    scan.x_m[i] *= 2.0F;
    scan.y_m[i] *= 2.0F;
    scan.z_m[i] *= 2.0F;
  }
  RangeImage image;
  image.build(scan.view());
  const SightLimits limits;
  int left_out = 0, seen = 0;
  for (int i = 0; i < 40 * 40 * 9; ++i) {
    const geometry::Vec3 middle{-14.0 + 0.7 * (i % 40), -14.0 + 0.7 * (i / 40 % 40),
                                -1.2 + 0.3 * (i / 1600)};
    const bool may_see = image.may_see(middle, 0.35, limits);
    left_out += may_see ? 0 : 1;
    for (int k = 0; k < 27; ++k) {
      const geometry::Vec3 place =
          middle + 0.2 * geometry::Vec3(k / 9 - 1, k / 3 % 3 - 1, k % 3 - 1);
      const bool known = image.look(place, limits) != Sight::kUnknown;
      seen += known ? 1 : 0;
      ASSERT_TRUE(may_see || !known) << place.transpose();
    }
  }
  EXPECT_GT(left_out, 5000);
  EXPECT_GT(seen, 1000);
}

}  // namespace
}  // namespace rali::map
