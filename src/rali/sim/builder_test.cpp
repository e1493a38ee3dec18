#include "rali/sim/builder.hpp"

#include <gtest/gtest.h>

#include "rali/sim/navigation.hpp"

namespace rali::sim {
namespace {

using geometry::Vec3;

// The floor in front ended at the wall and the floor of a room started behind it. Each open door
// had a gap in its floor as wide as the wall, which no vehicle can cross.
TEST(Builder, vehicles_drive_into_every_room_behind_an_open_door) {
  std::size_t places = 0;
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    TriangleMesh mesh;
    Rng rng(seed, "builder");
    Builder build(mesh, rng);
    build.lived_in_wall({0.0, 0.0, 0.0}, {30.0, 0.0, 0.0}, 2.7, 4.0, 3.0);
    build.slab(0.0, 0.0, 30.0, 3.0, 0.0);
    NavigationOptions options;
    options.cell_m = 0.05;
    const auto grid = NavigationGrid::build(mesh, options);
    ASSERT_TRUE(grid.has_value());
    for (double x = 0.5; x < 29.5; x += 0.5) {
      const Vec3 inside(x, -0.6, 0.0);  // furniture starts farther behind
      if (!grid->free_at(inside)) continue;
      ++places;
      EXPECT_TRUE(grid->plan({15.0, 1.5, 0.0}, inside).has_value())
          << "seed " << seed << " at " << inside.transpose();
    }
  }
  EXPECT_GE(places, 10U);
}

}  // namespace
}  // namespace rali::sim
