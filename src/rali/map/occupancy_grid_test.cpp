#include "rali/map/occupancy_grid.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "rali/map/test_world.hpp"

namespace rali::map {
namespace {

using test::look_around;
using test::pose_at;
using test::Room;
using test::Scan;

CellState state_at(const CellMap& grid, double x_m, double y_m) {
  return grid.at(grid.cell_at({x_m, y_m}));
}

TEST(GroundHeight, is_0_6_m_for_a_lidar_at_that_height) {
  const auto scan = look_around(Room{}, pose_at(10, 5, 0.6), 0.0);
  const auto ground = ground_below(scan.view());
  ASSERT_TRUE(ground.has_value());
  EXPECT_NEAR(ground->below_body_m, 0.6, 0.03);
  EXPECT_EQ(ground->rise_map.norm(), 0.0);
}

/// A passage whose floor, walls and vehicle are inclined about y of map: it climbs along -x.
Scan in_incline(double x_m, double angle_rad) {
  const Room passage{{0.0, 0.0, 0.0}, {60.0, 5.0, 3.0}, {}};
  Scan scan = look_around(passage, pose_at(x_m, 2.5, 0.6), x_m);
  scan.T_map_body =
      geometry::SE3{geometry::rotation_from_rpy(0.0, angle_rad, 0.0), {0, 0, 0}} * scan.T_map_body;
  return scan;
}

TEST(GroundHeight, follows_the_incline_on_which_the_vehicle_stands) {
  for (const double degrees : {4.0, 12.0, 28.0}) {
    const double angle_rad = degrees * std::numbers::pi / 180.0;
    const auto ground = ground_below(in_incline(20.0, angle_rad).view());
    ASSERT_TRUE(ground.has_value()) << degrees;
    EXPECT_NEAR(ground->below_body_m, 0.6 / std::cos(angle_rad), 0.03) << degrees;
    EXPECT_NEAR(ground->rise_map.x(), -std::tan(angle_rad), 1e-6) << degrees;
    EXPECT_NEAR(ground->rise_map.y(), 0.0, 1e-6) << degrees;
  }
}

TEST(GroundHeight, is_level_where_only_the_body_is_tilted) {
  geometry::SE3 tilted = pose_at(10, 5, 0.6);
  tilted.R = geometry::rotation_from_rpy(0.0, 0.1, 0.0);
  const auto ground = ground_below(look_around(Room{}, tilted, 0.0).view());
  ASSERT_TRUE(ground.has_value());
  EXPECT_NEAR(ground->below_body_m, 0.6, 0.03);
  EXPECT_EQ(ground->rise_map.norm(), 0.0);
}

TEST(GroundHeight, is_empty_where_no_floor_is_measured) {
  test::Scan scan;
  for (int i = 0; i < 100; ++i) scan.add(3, 0.1 * i, 1.0);
  EXPECT_FALSE(ground_below(scan.view()).has_value());
}

CellMap grid_of(const Room& room, int keyframes = 3) {
  GridBuilder builder(GridSettings{});
  for (int k = 0; k < keyframes; ++k) {
    builder.add(look_around(room, pose_at(8.0 + 0.5 * k, 5, 0.6, 0.3 * k), k).view());
  }
  const auto grid = builder.finish();
  EXPECT_TRUE(grid.has_value());
  return *grid;
}

TEST(OccupancyGrid, inside_is_free_walls_are_occupied_and_outside_is_unknown) {
  const CellMap grid = grid_of(Room{});
  EXPECT_EQ(state_at(grid, 8.0, 5.0), CellState::kFree);
  EXPECT_EQ(state_at(grid, 12.0, 7.0), CellState::kFree);
  EXPECT_EQ(state_at(grid, 3.0, 2.0), CellState::kFree);
  EXPECT_EQ(state_at(grid, 10.0, 10.001), CellState::kOccupied);
  EXPECT_EQ(state_at(grid, 10.0, 12.0), CellState::kUnknown);
  EXPECT_EQ(state_at(grid, 1000.0, 0.0), CellState::kUnknown);
}

TEST(OccupancyGrid, behind_a_pillar_stays_unknown) {
  Room room;
  room.cylinders.push_back({10.0, 8.0, 0.3, 2.0});
  GridBuilder builder(GridSettings{});
  builder.add(look_around(room, pose_at(10, 5, 0.6), 0).view());
  const auto grid = builder.finish();
  ASSERT_TRUE(grid.has_value());
  EXPECT_EQ(state_at(*grid, 10.0, 7.72), CellState::kOccupied);
  EXPECT_EQ(state_at(*grid, 10.0, 7.0), CellState::kFree);
  EXPECT_EQ(state_at(*grid, 10.0, 8.6), CellState::kUnknown);
}

TEST(OccupancyGrid, cells_passed_by_a_walking_person_end_up_free) {
  GridBuilder builder(GridSettings{});
  for (int k = 0; k < 12; ++k) {
    Room room;
    room.cylinders.push_back({6.0 + 0.6 * k, 7.0, 0.25, 1.7});
    builder.add(look_around(room, pose_at(8.0, 5, 0.6), k).view());
  }
  const auto grid = builder.finish();
  ASSERT_TRUE(grid.has_value());
  EXPECT_EQ(state_at(*grid, 7.2, 6.8), CellState::kFree);
  EXPECT_EQ(state_at(*grid, 9.0, 6.8), CellState::kFree);
}

TEST(OccupancyGrid, rays_without_return_clear_nothing) {
  GridBuilder builder(GridSettings{});
  auto scan = look_around(Room{}, pose_at(8, 5, 0.6), 0);
  test::Scan half;
  half.T_map_body = scan.T_map_body;
  for (std::size_t i = 0; i < scan.x_m.size(); ++i) {
    if (scan.x_m[i] > 0.0F) {
      half.add(static_cast<double>(scan.x_m[i]), static_cast<double>(scan.y_m[i]),
               static_cast<double>(scan.z_m[i]), scan.ring[i]);
    }
  }
  builder.add(half.view());
  const auto grid = builder.finish();
  ASSERT_TRUE(grid.has_value());
  EXPECT_EQ(state_at(*grid, 12.0, 5.0), CellState::kFree);
  EXPECT_EQ(state_at(*grid, 4.0, 5.0), CellState::kUnknown);
}

TEST(OccupancyGrid, an_inclined_passage_is_free_between_its_walls) {
  const double angle_rad = 25.0 * std::numbers::pi / 180.0;
  GridBuilder builder(GridSettings{});
  for (int k = 0; k < 3; ++k) builder.add(in_incline(20.0 + 0.5 * k, angle_rad).view());
  const auto grid = builder.finish();
  ASSERT_TRUE(grid.has_value());
  for (double along_m = 12.0; along_m < 30.0; along_m += 1.0) {
    const double x_m = along_m * std::cos(angle_rad);
    EXPECT_EQ(state_at(*grid, x_m, 2.5), CellState::kFree) << along_m;
    EXPECT_EQ(state_at(*grid, x_m, 1.0), CellState::kFree) << along_m;
  }
  EXPECT_EQ(state_at(*grid, 20.0, 0.01), CellState::kOccupied);
  EXPECT_EQ(state_at(*grid, 20.0, -0.5), CellState::kUnknown);
}

TEST(OccupancyGrid, a_ramp_ahead_of_the_last_pose_is_no_obstacle) {
  GridBuilder builder(GridSettings{});
  Scan s;
  s.T_map_body = pose_at(0.0, 0.0, 0.6);
  for (double x = 1.0; x < 15.0; x += 0.3) {
    for (double y = -2.0; y <= 2.0; y += 0.1) s.add(x, y, -0.6 + 0.12 * std::max(0.0, x - 4.0));
  }
  builder.add(s.view());
  const auto grid = builder.finish();
  ASSERT_TRUE(grid.has_value());
  // The last ray comes down to 0.15 m above the ramp at (0.6 - 0.15) / 0.6 of its 15 m.
  for (double x = 1.0; x < 11.0; x += 0.5) {
    EXPECT_EQ(state_at(*grid, x, 0.0), CellState::kFree) << x;
  }
  for (double x = 11.5; x < 14.0; x += 0.5) {
    EXPECT_EQ(state_at(*grid, x, 0.0), CellState::kUnknown) << x;
  }
}

TEST(OccupancyGrid, a_lidar_above_the_band_clears_only_where_its_rays_are_within) {
  GridBuilder builder(GridSettings{});
  const Room hall{{0.0, 0.0, 0.0}, {40.0, 30.0, 8.0}, {}};
  builder.add(look_around(hall, pose_at(20.0, 15.0, 2.1), 0.0).view());
  const auto grid = builder.finish();
  ASSERT_TRUE(grid.has_value());
  // Its steepest ray comes down to 1.5 m at 0.6 m / tan(15 degrees) = 2.24 m.
  EXPECT_EQ(state_at(*grid, 21.5, 15.0), CellState::kUnknown);
  EXPECT_EQ(state_at(*grid, 23.0, 15.0), CellState::kFree);
  EXPECT_EQ(state_at(*grid, 20.0, 15.0), CellState::kFree) << "the vehicle is there";
}

TEST(OccupancyGrid, each_vehicle_has_its_own_height_above_the_ground) {
  GridBuilder builder(GridSettings{});
  const Scan low = look_around(Room{}, pose_at(8.0, 5.0, 0.5), 0.0);
  const Scan high = look_around(Room{}, pose_at(8.0, 5.0, 1.3), 1.0);
  for (int k = 0; k < 4; ++k) builder.add(high.view());
  KeyframeView of_second = low.view();
  of_second.vehicle = 1;
  builder.add(of_second);
  builder.add(of_second);
  const auto grid = builder.finish();
  ASSERT_TRUE(grid.has_value());
  // With one height for both, the floor rings of the lower one would be obstacles.
  for (double x_m = 5.0; x_m < 11.0; x_m += 0.05) {
    EXPECT_NE(state_at(*grid, x_m, 5.0), CellState::kOccupied) << x_m;
  }
}

TEST(OccupancyGrid, returns_an_error_with_a_remedy_without_ground_height) {
  const GridBuilder builder(GridSettings{});
  const auto grid = builder.finish();
  ASSERT_FALSE(grid.has_value());
  EXPECT_EQ(grid.error().code, ErrorCode::kNoAnswer);
  EXPECT_FALSE(grid.error().remedy.empty());
}

TEST(OccupancyGrid, a_grid_beyond_the_limit_is_refused_not_allocated) {
  GridSettings settings;
  settings.cells_max = 1e4;
  GridBuilder builder(settings);
  builder.add(look_around(Room{}, pose_at(8, 5, 0.6), 0).view());
  const auto grid = builder.finish();
  ASSERT_FALSE(grid.has_value());
  EXPECT_EQ(grid.error().code, ErrorCode::kMachine);
}

}  // namespace
}  // namespace rali::map
