#include "rali/map/occupancy_grid.hpp"

#include <gtest/gtest.h>

#include "rali/map/ground_height.hpp"
#include "rali/map/test_world.hpp"

namespace rali::map {
namespace {

using test::look_around;
using test::pose_at;
using test::Room;

TEST(GroundHeight, is_0_6_m_for_a_lidar_at_that_height) {
  const auto scan = look_around(Room{}, pose_at(10, 5, 0.6), 0.0);
  const auto height = ground_below_body(scan.view());
  ASSERT_TRUE(height.has_value());
  EXPECT_NEAR(*height, 0.6, 0.03);
}

TEST(GroundHeight, is_empty_where_no_floor_is_measured) {
  test::Scan scan;
  for (int i = 0; i < 100; ++i) scan.add(3, 0.1 * i, 1.0);
  EXPECT_FALSE(ground_below_body(scan.view()).has_value());
}

OccupancyGrid grid_of(const Room& room, int keyframes = 3) {
  GridBuilder builder(GridSettings{});
  for (int k = 0; k < keyframes; ++k) {
    builder.add(look_around(room, pose_at(8.0 + 0.5 * k, 5, 0.6, 0.3 * k), k).view());
  }
  const auto grid = builder.finish();
  EXPECT_TRUE(grid.has_value());
  return *grid;
}

TEST(OccupancyGrid, inside_is_free_walls_are_occupied_and_outside_is_unknown) {
  const OccupancyGrid grid = grid_of(Room{});
  EXPECT_EQ(grid.at(8.0, 5.0), kFree);
  EXPECT_EQ(grid.at(12.0, 7.0), kFree);
  EXPECT_EQ(grid.at(3.0, 2.0), kFree);
  EXPECT_EQ(grid.at(10.0, 10.001), kOccupied);
  EXPECT_EQ(grid.at(10.0, 12.0), kUnknownCell);
  EXPECT_EQ(grid.at(1000.0, 0.0), kUnknownCell);
}

TEST(OccupancyGrid, behind_a_pillar_stays_unknown) {
  Room room;
  room.cylinders.push_back({10.0, 8.0, 0.3, 2.0});
  GridBuilder builder(GridSettings{});
  builder.add(look_around(room, pose_at(10, 5, 0.6), 0).view());
  const auto grid = builder.finish();
  ASSERT_TRUE(grid.has_value());
  EXPECT_EQ(grid->at(10.0, 7.72), kOccupied);
  EXPECT_EQ(grid->at(10.0, 7.0), kFree);
  EXPECT_EQ(grid->at(10.0, 8.6), kUnknownCell);
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
  EXPECT_EQ(grid->at(7.2, 6.8), kFree);
  EXPECT_EQ(grid->at(9.0, 6.8), kFree);
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
  EXPECT_EQ(grid->at(12.0, 5.0), kFree);
  EXPECT_EQ(grid->at(4.0, 5.0), kUnknownCell);
}

TEST(OccupancyGrid, the_first_image_row_is_the_top_of_the_map) {
  const OccupancyGrid grid = grid_of(Room{}, 1);
  ASSERT_EQ(grid.cells.size(), grid.width * grid.height);
  const auto column = static_cast<std::size_t>((10.0 - grid.origin_map_m.x()) / grid.cell_m);
  std::size_t first_occupied = grid.height;
  for (std::size_t row = grid.height; row-- > 0;) {
    if (grid.cells[row * grid.width + column] == kOccupied) first_occupied = row;
  }
  const double y =
      grid.origin_map_m.y() + static_cast<double>(grid.height - 1 - first_occupied) * grid.cell_m;
  EXPECT_NEAR(y, 10.0, 0.06);
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
