#include "rali/fleet/facts/packed_points.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/fleet/facts/facts_for_test.hpp"

namespace rali::fleet {
namespace {

TEST(PackedPoints, morton_codes_interleave_coordinate_bits_and_decode_exactly) {
  // Offsets from the corner: x 1, y 2, z 4 -> bits x0 at 0, y1 at 4, z2 at 8.
  const PointCode corner{1 - kPointSteps, 2 - kPointSteps, 4 - kPointSteps, 0};
  EXPECT_EQ(curve_place(corner), 1U << 0 | 1U << 4 | 1U << 8);
  Rng rng(4);
  for (int k = 0; k < 1000; ++k) {
    const auto any = [&rng] {
      return static_cast<std::int32_t>(rng.below(2U << 20)) - kPointSteps;
    };
    const PointCode p{any(), any(), any(), 0};
    const PointCode back = point_at(curve_place(p));
    EXPECT_TRUE(back.x == p.x && back.y == p.y && back.z == p.z);
  }
}

TEST(PackedPoints, are_a_centimetre_grid_in_the_order_of_the_curve) {
  PointArrays given;
  given.push_back(1.004F, -2.0F, 0.5F);
  given.push_back(-3.0F, 0.0F, 0.0F);
  given.intensity = {200, 7};
  const PackedPoints packed(given);
  const PointArrays points = packed.unpacked();
  ASSERT_EQ(points.size(), 2U);
  EXPECT_EQ(points.x_m, (std::vector<float>{1.0F, -3.0F})) << "negative y first, before x counts";
  EXPECT_EQ(points.y_m, (std::vector<float>{-2.0F, 0.0F}));
  EXPECT_EQ(points.z_m, (std::vector<float>{0.5F, 0.0F}));
  EXPECT_EQ(points.intensity, (std::vector<std::uint8_t>{208, 0})) << "in steps of 16";
}

TEST(PackedPoints, stay_within_half_a_step_and_do_not_change_when_packed_again) {
  Rng rng(3, "points");
  for (const bool with_intensity : {false, true}) {
    for (const std::size_t n : {0, 1, 2, 999}) {
      const PackedPoints once = random_points(rng, n, with_intensity).points;
      ASSERT_EQ(once.size(), n);
      EXPECT_EQ(once.has_intensity(), with_intensity && n > 0);
      const PackedPoints twice(once.unpacked());
      EXPECT_EQ(once.bytes(), twice.bytes());
      const PackedPoints of_codes(once.codes(), once.has_intensity());
      EXPECT_EQ(once.bytes(), of_codes.bytes());
    }
  }
}

TEST(PackedPoints, without_a_usable_place_are_left_out) {
  PointArrays given;
  given.push_back(1.0F, 2.0F, 3.0F);
  given.push_back(std::numeric_limits<float>::quiet_NaN(), 0.0F, 0.0F);
  given.push_back(0.0F, std::numeric_limits<float>::infinity(), 0.0F);
  given.push_back(0.0F, 0.0F, 10486.0F);
  given.push_back(0.0F, 0.0F, -1e30F);
  const PackedPoints packed(given);
  ASSERT_EQ(packed.size(), 1U);
  EXPECT_EQ(packed.unpacked().z_m[0], 3.0F);
}

// A mission of an hour keeps ten million points.
TEST(PackedPoints, take_at_most_five_bytes_each) {
  Rng rng(4, "walls");
  PointArrays walls;
  for (int k = 0; k < 2500; ++k) {
    const double along_m = rng.uniform(-20.0, 20.0);
    walls.push_back(static_cast<float>(along_m), k % 2 == 0 ? 1.5F : -1.5F,
                    static_cast<float>(rng.uniform(-0.5, 2.0)));
    walls.intensity.push_back(static_cast<std::uint8_t>(rng.below(256)));
  }
  EXPECT_LE(PackedPoints(walls).bytes().size(), 5U * walls.size());
}

TEST(PackedPoints, share_their_bytes_with_copies) {
  Rng rng(5, "points");
  const PackedPoints points = random_points(rng, 100, false).points;
  const PackedPoints copy = points;
  EXPECT_EQ(&copy.bytes(), &points.bytes());
}

}  // namespace
}  // namespace rali::fleet
