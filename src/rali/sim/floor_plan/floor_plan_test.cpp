#include "rali/sim/floor_plan/floor_plan.hpp"

#include <cmath>
#include <limits>
#include <string>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace rali::sim {
namespace {

using geometry::Vec2;
using geometry::Vec3;

/// Rooms 4 x 3 m and 3.8 x 3 m, a wall of 0.2 m between them, a door of 1 m in it.
std::vector<FreeArea> two_rooms() {
  return {{rectangle(0.0, 0.0, 4.0, 3.0), 2.6, 0.6},
          {rectangle(4.2, 0.0, 8.0, 3.0), 2.6, 0.6},
          {rectangle(4.0, 1.0, 4.2, 2.0), 2.1, 0.5}};
}

std::string text_of(const WallPiece& w) {
  const auto number = [](double v) { return std::to_string(std::lround(v * 10.0)); };
  return number(w.a.x()) + "," + number(w.a.y()) + "-" + number(w.b.x()) + "," + number(w.b.y()) +
         ":" + number(w.bottom_m) + "-" + number(w.top_m);
}

double floor_area(const Outline& outline) {
  double area = 0.0;
  for (const SlabPiece& s : outline.slabs) {
    area += 0.5 * (s.x1 - s.x0) * (s.y_high0 - s.y_low0 + s.y_high1 - s.y_low1);
  }
  return area;
}

TEST(FloorPlan, two_rooms_and_a_door_have_the_expected_walls) {
  const auto outline = outline_of(two_rooms());
  ASSERT_TRUE(outline) << outline.error().message();
  std::vector<std::string> walls;  // decimetres, x,y-x,y:bottom-top
  for (const WallPiece& wall : outline->walls) walls.push_back(text_of(wall));
  const std::vector<std::string> expected{
      "0,0-0,30:0-26",     "0,0-40,0:0-26",    "0,30-40,30:0-26",   "40,0-40,10:0-26",
      "40,10-40,20:21-26", "40,10-42,10:0-21", "40,20-40,30:0-26",  "40,20-42,20:0-21",
      "42,0-42,10:0-26",   "42,0-80,0:0-26",   "42,10-42,20:21-26", "42,20-42,30:0-26",
      "42,30-80,30:0-26",  "80,0-80,30:0-26"};
  EXPECT_EQ(walls, expected);
}

TEST(FloorPlan, floors_cover_the_union_once_even_where_areas_overlap) {
  EXPECT_NEAR(floor_area(*outline_of(two_rooms())), 4.0 * 3.0 + 3.8 * 3.0 + 0.2, 1e-9);
  // A cross of two 6 x 2 m corridors: 12 + 12 - 4.
  const auto cross = outline_of(
      {{rectangle(0.0, 2.0, 6.0, 4.0), 2.5, 0.6}, {rectangle(2.0, 0.0, 4.0, 6.0), 2.5, 0.6}});
  ASSERT_TRUE(cross);
  EXPECT_NEAR(floor_area(*cross), 20.0, 1e-9);
  EXPECT_EQ(cross->walls.size(), 12U);
  // A triangle: half of 4 x 3.
  const auto triangle = outline_of({{{{0.0, 0.0}, {4.0, 0.0}, {0.0, 3.0}}, 2.5, 0.6}});
  EXPECT_NEAR(floor_area(*triangle), 6.0, 1e-9);
  EXPECT_EQ(triangle->walls.size(), 3U);
}

TEST(FloorPlan, duplicate_areas_do_not_change_the_outline) {
  std::vector<FreeArea> twice = two_rooms();
  twice.push_back(twice.front());
  EXPECT_EQ(outline_of(twice)->walls.size(), outline_of(two_rooms())->walls.size());
  EXPECT_NEAR(floor_area(*outline_of(twice)), floor_area(*outline_of(two_rooms())), 1e-9);
}

TEST(FloorPlan, a_higher_room_has_a_wall_above_the_lower_one) {
  const auto outline = outline_of(
      {{rectangle(0.0, 0.0, 4.0, 4.0), 5.0, 0.6}, {rectangle(4.0, 0.0, 8.0, 4.0), 3.0, 0.6}});
  ASSERT_TRUE(outline);
  bool found = false;
  for (const WallPiece& wall : outline->walls) found = found || text_of(wall) == "40,0-40,40:30-50";
  EXPECT_TRUE(found);
}

TEST(FloorPlan, rotated_rooms_are_closed) {
  const FreeArea turned{rectangle(Vec2(10.0, 5.0), Vec2(6.0, 4.0), 0.7), 3.0, 0.6};
  const auto outline = outline_of({turned});
  ASSERT_TRUE(outline);
  EXPECT_EQ(outline->walls.size(), 4U);
  EXPECT_NEAR(floor_area(*outline), 24.0, 1e-4);
}

TEST(FloorPlan, mesh_has_walls_floor_ceiling_and_furniture) {
  FloorPlan plan;
  plan.areas = {{rectangle(0.0, 0.0, 5.0, 4.0), 3.0, 0.6}};
  const auto room = floor_plan_mesh(plan);
  ASSERT_TRUE(room);
  EXPECT_EQ(room->triangles.size(), 2U * (4 + 1 + 1));
  plan.ceiling = false;
  plan.furniture.push_back({{1.0, 1.0}, {1.0, 1.0}, 0.0, 0.0, 0.7, 0.0, 0.5});
  EXPECT_EQ(floor_plan_mesh(plan)->triangles.size(), 2U * (4 + 1 + 6));
  EXPECT_EQ(room->upper_corner(), Vec3(5.0, 4.0, 3.0));
  EXPECT_FALSE(floor_plan_mesh(FloorPlan{}));
}

TEST(FloorPlan, areas_with_more_than_5000_walls_are_refused) {
  std::vector<FreeArea> comb;  // 110 x 110 crossing strips: 12 100 crossings
  for (int i = 0; i < 110; ++i) {
    comb.push_back({rectangle(0.0, i, 110.0, i + 0.5), 3.0, 0.6});
    comb.push_back({rectangle(i, 0.0, i + 0.5, 110.0), 3.0, 0.6});
  }
  const auto outline = outline_of(comb);
  ASSERT_FALSE(outline);
  EXPECT_NE(outline.error().what.find("more than 5000 walls"), std::string::npos);
}

TEST(Polygon, errors_are_described) {
  EXPECT_EQ(polygon_fault(rectangle(0.0, 0.0, 1.0, 2.0)), "");
  EXPECT_EQ(polygon_fault({{0, 0}, {1, 0}}), "has 2 corners; an area has at least 3");
  EXPECT_EQ(polygon_fault({{0, 0}, {1, 1}, {1, 0}, {0, 1}}),
            "crosses itself: the edges from [0, 0] and [1, 0] meet");
  EXPECT_EQ(polygon_fault({{0, 0}, {1, 0}, {1, 0}, {0, 1}}), "has the corner [1, 0] twice");
  EXPECT_EQ(polygon_fault({{0, 0}, {1, 0}, {2, 0}}), "has no area");
  EXPECT_EQ(polygon_fault({{0, 0}, {1, 0}, {0, std::numeric_limits<double>::quiet_NaN()}}),
            "has a corner that is no number");
  EXPECT_NE(polygon_fault({{0, 0}, {1e7, 0}, {0, 1}}).find("more than 100 km away"),
            std::string::npos);
}

TEST(Polygon, inside_test_handles_concave_polygons) {
  const Polygon ell{{0, 0}, {4, 0}, {4, 1}, {1, 1}, {1, 4}, {0, 4}};
  EXPECT_TRUE(is_inside(ell, {0.5, 3.0}));
  EXPECT_TRUE(is_inside(ell, {3.0, 0.5}));
  EXPECT_FALSE(is_inside(ell, {2.0, 2.0}));
  EXPECT_FALSE(is_inside(ell, {-1.0, 0.5}));
}

}  // namespace
}  // namespace rali::sim
