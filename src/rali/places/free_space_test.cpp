#include "rali/places/free_space.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace rali::places {
namespace {

using geometry::Vec3f;

/// Puts rays along x from kOrigin into the middle of cells.
FreeSpaceSettings settings() {
  FreeSpaceSettings s;
  s.range_m = 15.1;
  s.height_m = 3.1;
  return s;
}

const Vec3f kOrigin(0.1F, 0.1F, 0.1F);
const Vec3f kThing(5.1F, 0.1F, 0.1F);
const Vec3f kBehind(9.1F, 0.1F, 0.1F);
const Vec3f kBeside(5.1F, 0.3F, 0.1F);  // the next cell

/// State of kThing's cell after scans with these points each.
Sight thing_after(const std::vector<std::vector<Vec3f>>& scans) {
  std::vector<Look> looks;
  for (const auto& points : scans) looks.push_back({kOrigin, points});
  FreeSpace space;
  space.build(looks, settings());
  return space.look(kThing.cast<double>());
}

TEST(free_space, marks_passed_cells_free_hit_cells_hit_and_others_unknown) {
  FreeSpaceSettings s = settings();
  const std::vector<Vec3f> points(3, kThing);
  const std::vector<Look> looks{{kOrigin, points}};
  FreeSpace space;
  space.build(looks, s);
  EXPECT_EQ(space.look({2.5, 0.1, 0.1}), Sight::kFree);
  EXPECT_EQ(space.look({5.1, 0.1, 0.1}), Sight::kHit);
  EXPECT_EQ(space.look({6.0, 0.1, 0.1}), Sight::kUnknown);
  EXPECT_EQ(space.look({2.5, 1.1, 0.1}), Sight::kUnknown);
  EXPECT_EQ(space.look({1e9, 0.0, 0.0}), Sight::kUnknown);
  EXPECT_EQ(space.cells(), 26U) << "from the sensor to the thing: the rest is not kept";
  s.cells_max = 1000;
  space.build(looks, s);
  EXPECT_EQ(space.look({2.5, 0.1, 0.1}), Sight::kUnknown) << "1000 cells do not reach so far";
}

TEST(free_space, respects_the_cell_limit_for_distant_origins) {
  // The range shrinks until the box is thinner than a cell, which is a cell all the same.
  const std::vector<Vec3f> a{Vec3f(-89999.0F, 0.0F, 0.0F)}, b{Vec3f(90001.0F, 0.0F, 0.0F)};
  const std::vector<Look> looks{{Vec3f(-90000.0F, 0.0F, 0.0F), a},
                                {Vec3f(90000.0F, 0.0F, 0.0F), b}};
  const FreeSpaceSettings s;
  FreeSpace space;
  space.build(looks, s);
  EXPECT_LE(space.cells(), static_cast<std::size_t>(s.cells_max));
}

TEST(free_space, marks_a_cell_loose_after_two_scans_pass_through_it) {
  EXPECT_EQ(thing_after({{kThing}, {kBehind}, {kBehind}}), Sight::kLoose);
  // Passed before or after the hit.
  EXPECT_EQ(thing_after({{kBehind}, {kThing}, {kBehind}}), Sight::kLoose);
  // However often it was hit: it has gone since, or lets rays through.
  EXPECT_EQ(thing_after({{kThing}, {kThing}, {kThing}, {kBehind}, {kBehind}}), Sight::kLoose);
}

TEST(free_space, does_not_mark_a_cell_loose_after_one_scan_passes_it) {
  EXPECT_EQ(thing_after({{kThing}, {kThing}, {kBehind}}), Sight::kHit);
  EXPECT_EQ(thing_after({{kThing}, {kBehind, kBehind, kBehind}}), Sight::kHit);
}

TEST(free_space, keeps_a_hit_if_passing_scans_also_hit_it_or_its_neighbour) {
  EXPECT_EQ(thing_after({{kThing}, {kBehind, kBeside}, {kBehind, kBeside}}), Sight::kHit);
  // Other rays of the scan that hits the thing pass its cell: the scan counts as a hit only.
  EXPECT_EQ(thing_after({{kThing, kBehind}, {kThing, kBehind}, {kThing, kBehind}}), Sight::kHit);
}

TEST(free_space, is_unknown_without_scans_or_points) {
  FreeSpace space;
  space.build({}, settings());
  EXPECT_EQ(space.look({0.0, 0.0, 0.0}), Sight::kUnknown);
  EXPECT_EQ(thing_after({{}, {}}), Sight::kUnknown);
}

}  // namespace
}  // namespace rali::places
