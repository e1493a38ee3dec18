#include "rali/sim/navigation.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/sim/clearance.hpp"
#include "rali/sim/floor_plan/floor_plan.hpp"
#include "rali/sim/tunnels/tunnels.hpp"

namespace rali::sim {
namespace {

using geometry::Vec3;

/// Two rooms of 5 x 4 m with a door of `door_m` at (5.1, 2).
TriangleMesh rooms(double door_m) {
  FloorPlan plan;
  plan.areas = {{rectangle(0.0, 0.0, 5.0, 4.0), 2.6, 0.6},
                {rectangle(5.2, 0.0, 10.0, 4.0), 2.6, 0.6},
                {rectangle(5.0, 2.0 - 0.5 * door_m, 5.2, 2.0 + 0.5 * door_m), 2.1, 0.6}};
  return floor_plan_mesh(plan).value();
}

double length(const std::vector<Vec3>& path) {
  double sum = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) sum += (path[i] - path[i - 1]).norm();
  return sum;
}

TEST(Clearance, distances_to_walls_match_the_floor_plan) {
  const TriangleMesh mesh = rooms(1.0);
  const Clearance clearance(mesh);
  const VehicleShape shape;
  EXPECT_NEAR(clearance.distance_m({1.0, 2.0, 0.0}, shape, 5.0), 1.0, 1e-6);
  EXPECT_NEAR(clearance.distance_m({2.5, 3.5, 0.0}, shape, 5.0), 0.5, 1e-6);
  EXPECT_NEAR(clearance.distance_m({5.1, 2.0, 0.0}, shape, 5.0), 0.5, 1e-6);
  EXPECT_EQ(clearance.distance_m({2.5, 2.0, 0.0}, shape, 0.7), 0.7);
  EXPECT_TRUE(clearance.free_at({0.31, 2.0, 0.0}, shape));
  EXPECT_FALSE(clearance.free_at({0.29, 2.0, 0.0}, shape));
}

TEST(Clearance, low_sills_and_high_lintels_are_no_obstacles_but_tables_are) {
  TriangleMesh mesh;
  mesh.add_box({0.0, 0.0, 0.0}, {1.0, 1.0, 0.10}, 0.0, 0.5);
  mesh.add_box({10.0, 0.0, 1.0}, {1.0, 1.0, 0.5}, 0.0, 0.5);
  mesh.add_box({20.0, 0.0, 0.6}, {1.0, 1.0, 0.1}, 0.0, 0.5);
  const Clearance clearance(mesh);
  EXPECT_TRUE(clearance.free_at({0.0, 0.0, 0.0}, {}));
  EXPECT_TRUE(clearance.free_at({10.0, 0.0, 0.0}, {}));
  EXPECT_FALSE(clearance.free_at({20.0, 0.0, 0.0}, {}));
}

TEST(Clearance, first_contact_of_a_path_through_a_wall_is_before_it) {
  const TriangleMesh mesh = rooms(1.0);
  const Clearance clearance(mesh);
  const auto contact = clearance.first_contact({{1.0, 0.6, 0.0}, {9.0, 0.6, 0.0}}, {});
  ASSERT_TRUE(contact);
  EXPECT_NEAR(contact->x(), 4.75, 0.06);
  EXPECT_FALSE(clearance.first_contact({{1.0, 2.0, 0.0}, {9.0, 2.0, 0.0}}, {}));
}

TEST(Clearance, ground_is_the_nearest_surface_below) {
  const TriangleMesh mesh = rooms(1.0);
  const Clearance clearance(mesh);
  EXPECT_NEAR(clearance.ground_below(2.0, 2.0, 0.5, 1.0).value_or(-1.0), 0.0, 1e-9);
  EXPECT_NEAR(clearance.ground_below(2.0, 2.0, 5.0, 5.0).value_or(-1.0), 2.6, 1e-6);
  EXPECT_FALSE(clearance.ground_below(-3.0, 2.0, 0.5, 1.0));
  EXPECT_EQ(clearance.surfaces_at(2.0, 2.0).size(), 2U);
}

TEST(Navigation, paths_lead_through_the_door_and_are_within_6_percent_of_shortest) {
  const TriangleMesh mesh = rooms(1.0);
  const auto grid = NavigationGrid::build(mesh);
  ASSERT_TRUE(grid) << grid.error().message();
  const auto path = grid->plan({1.0, 3.0, 0.0}, {9.0, 3.0, 0.0});
  ASSERT_TRUE(path) << path.error().message();
  const double shortest = 2.0 * std::hypot(4.1, 1.0);
  EXPECT_GE(length(*path), shortest - 0.3);
  EXPECT_LE(length(*path), shortest * 1.06);
  EXPECT_LE(path->size(), 8U);
  EXPECT_EQ(path->front(), Vec3(1.0, 3.0, 0.0));
  EXPECT_EQ(path->back(), Vec3(9.0, 3.0, 0.0));
  EXPECT_FALSE(Clearance(mesh).first_contact(*path, {}));
}

TEST(Navigation, too_narrow_doors_are_not_passable) {
  const TriangleMesh mesh = rooms(0.5);
  const auto grid = NavigationGrid::build(mesh);
  const auto path = grid->plan({1.0, 3.0, 0.0}, {9.0, 3.0, 0.0});
  ASSERT_FALSE(path);
  EXPECT_EQ(path.error().code, ErrorCode::kNoAnswer);
  EXPECT_NE(path.error().what.find("there is no path from [1.00, 3.00] to [9.00, 3.00]"),
            std::string::npos);
}

TEST(Navigation, walls_and_outside_positions_are_not_free) {
  const TriangleMesh mesh = rooms(1.0);
  const auto grid = NavigationGrid::build(mesh);
  EXPECT_TRUE(grid->free_at({2.0, 2.0, 0.0}));
  EXPECT_FALSE(grid->free_at({0.1, 2.0, 0.0}));
  EXPECT_FALSE(grid->free_at({5.1, 3.0, 0.0}));
  EXPECT_FALSE(grid->free_at({-2.0, 2.0, 0.0}));
  EXPECT_FALSE(grid->free_at({NAN, 2.0, 0.0}));
  EXPECT_NEAR(grid->clearance_m({2.5, 2.0, 0.0}), 2.0, 0.25);
  const auto outside = grid->plan({-2.0, 0.0, 0.0}, {2.0, 2.0, 0.0});
  ASSERT_FALSE(outside);
  EXPECT_EQ(outside.error().where, "from");
}

TEST(Navigation, storeys_above_each_other_are_kept_separate) {
  const World ramp = ramp_world({}, Rng(1, "test")).value();
  const auto grid = NavigationGrid::build(ramp.mesh);
  ASSERT_TRUE(grid);
  const auto path = grid->plan(ramp.route.front(), ramp.route.back());
  ASSERT_TRUE(path) << path.error().message();
  EXPECT_NEAR(path->back().z() - path->front().z(), 6.0, 0.1);
  // Two turns; the inner side of a lane of 9 m radius and 4.2 m width is shorter.
  EXPECT_GT(length(*path), 2.0 * 2.0 * 3.14 * 7.0);
  EXPECT_LT(length(*path), 2.0 * 2.0 * 3.15 * 9.0 + 30.0);
}

TEST(Navigation, the_farthest_reachable_position_is_in_the_other_room) {
  const TriangleMesh mesh = rooms(1.0);
  const auto grid = NavigationGrid::build(mesh);
  const auto far = grid->farthest_from({0.6, 0.6, 0.0});
  ASSERT_TRUE(far);
  EXPECT_GT(far->x(), 9.0);
}

TEST(Navigation, empty_and_oversized_meshes_are_refused) {
  EXPECT_FALSE(NavigationGrid::build(TriangleMesh{}));
  TriangleMesh plain;
  plain.add_quad({0.0, 0.0, 0.0}, {20000.0, 0.0, 0.0}, {0.0, 20000.0, 0.0}, 0.5);
  const auto grid = NavigationGrid::build(plain);
  ASSERT_FALSE(grid);
  EXPECT_NE(grid.error().what.find("too large"), std::string::npos);
}

}  // namespace
}  // namespace rali::sim
