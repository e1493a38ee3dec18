#include "rali/ranging/seen_space.hpp"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace rali::ranging {
namespace {

using geometry::Vec3;

constexpr double kRadius_m = 80.0;
constexpr double kHalf_m = 4.0;  ///< from the middle of the road to its walls

/// On the middle of a road that bends around the origin.
Vec3 on_road(double way_m) {
  const double angle = way_m / kRadius_m;
  return kRadius_m * Vec3(std::sin(angle), std::cos(angle), 0.0);
}

/// Crossings of the two walls, counted along the line.
int walls_between(const Vec3& p, const Vec3& q) {
  int crossings = 0;
  const int steps = 1 + static_cast<int>((q - p).norm() / 0.05);
  for (const double wall_m : {kRadius_m - kHalf_m, kRadius_m + kHalf_m}) {
    bool beyond = p.norm() > wall_m;
    for (int k = 1; k <= steps; ++k) {
      const bool now = (p + (static_cast<double>(k) / steps) * (q - p)).norm() > wall_m;
      if (now != beyond) ++crossings;
      beyond = now;
    }
  }
  return crossings;
}

std::vector<Vec3> driven(double length_m) {
  std::vector<Vec3> places;
  for (double way_m = 0.0; way_m <= length_m; way_m += 3.0) places.push_back(on_road(way_m));
  return places;
}

bool leaves(double way_m, const std::vector<Vec3>& places) {
  return leaves_seen_space(on_road(0.0), on_road(way_m),
                           [&](const Vec3& x) { return is_outside(x, places, walls_between); });
}

// By hand: the chord of 50.4 m is 4 m off the arc at its middle, that of 70 m 7.6 m.
TEST(SeenSpace, is_left_by_the_chord_of_a_bend_that_passes_behind_the_inner_wall) {
  const std::vector<Vec3> places = driven(70.0);
  EXPECT_FALSE(leaves(20.0, places));
  EXPECT_FALSE(leaves(48.0, places));
  EXPECT_TRUE(leaves(58.0, places));
  EXPECT_TRUE(leaves(70.0, places));
}

TEST(SeenSpace, is_not_left_where_nobody_has_been) {
  EXPECT_FALSE(leaves(70.0, {}));
  EXPECT_FALSE(leaves(70.0, {Vec3(0.0, -200.0, 0.0)}));
}

// A pillar of 1 m hides a point of the line from one place, not from all of them.
TEST(SeenSpace, is_not_left_behind_a_pillar) {
  const Vec3 pillar(10.0, 2.0, 0.0);
  const auto surfaces = [&](const Vec3& p, const Vec3& q) {
    const Vec3 along = q - p;
    const double s = std::min(1.0, std::max(0.0, along.dot(pillar - p) / along.squaredNorm()));
    return (p + s * along - pillar).norm() < 0.5 ? 2 : 0;
  };
  std::vector<Vec3> places;
  for (double x = 0.0; x <= 20.0; x += 2.0) places.emplace_back(x, 0.0, 0.0);
  const auto outside = [&](const Vec3& x) { return is_outside(x, places, surfaces); };
  EXPECT_FALSE(leaves_seen_space(Vec3(0.0, 4.0, 0.0), Vec3(20.0, 4.0, 0.0), outside));
}

TEST(SeenSpace, has_points_on_a_wall_inside) {
  const std::vector<Vec3> places = driven(70.0);
  const Vec3 middle = on_road(30.0);
  EXPECT_FALSE(is_outside((1.0 - (kHalf_m + 0.2) / kRadius_m) * middle, places, walls_between));
  EXPECT_TRUE(is_outside((1.0 - (kHalf_m + 0.6) / kRadius_m) * middle, places, walls_between));
}

}  // namespace
}  // namespace rali::ranging
