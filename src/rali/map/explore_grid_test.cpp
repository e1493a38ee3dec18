#include "rali/map/explore_grid.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "rali/map/test_world.hpp"

namespace rali::map {
namespace {

using geometry::Vec2;
using test::look_around;
using test::pose_at;
using test::Room;
using test::Scan;

KeyframeId key(std::uint32_t seq, std::uint16_t vehicle = 0) { return {VehicleId{vehicle}, seq}; }

CellState state_at(const ExploreGrid& grid, double x, double y) {
  const auto map = grid.picture();
  EXPECT_TRUE(map.has_value());
  return map->at(map->cell_at({x, y}));
}

/// A sensor at the body's origin, `height_m` above level ground.
Scan standing_at(double x, double y, double height_m) {
  Scan s;
  s.T_map_body = pose_at(x, y, height_m);
  return s;
}

/// An upright wall as points, in body: x = distance, y in [-half, half].
void add_wall(Scan& s, double distance_m, double half_m, double low_m, double high_m) {
  const double ground_m = -s.T_map_body.p.z();
  for (double y = -half_m; y <= half_m; y += 0.1) {
    for (double z = low_m; z <= high_m; z += 0.2) s.add(distance_m, y, ground_m + z);
  }
}

ExploreSettings with_height(double below_m) {
  ExploreSettings s;
  s.ground_below_body_m = below_m;
  return s;
}

TEST(ExploreGrid, log_odds_of_one_wall_match_hand_computed_values) {
  ExploreGrid grid(with_height(0.8));
  Scan s = standing_at(0.1, 0.1, 0.8);
  add_wall(s, 4.0, 1.0, 0.0, 2.0);
  ASSERT_TRUE(grid.add(key(0), s.view()));
  EXPECT_NEAR(grid.log_odds_at({4.1, 0.1}), 0.85, 1e-9);
  EXPECT_NEAR(grid.log_odds_at({2.1, 0.1}), -0.4, 1e-9);
  EXPECT_EQ(grid.log_odds_at({4.5, 0.1}), 0.0);
  EXPECT_EQ(state_at(grid, 4.1, 0.1), CellState::kOccupied);
  EXPECT_EQ(state_at(grid, 2.1, 0.1), CellState::kFree);
  EXPECT_EQ(state_at(grid, 4.5, 0.1), CellState::kUnknown);
  EXPECT_EQ(state_at(grid, -2.0, 0.1), CellState::kUnknown) << "no return clears nothing";
  EXPECT_EQ(state_at(grid, 0.1, 0.1), CellState::kFree) << "the vehicle is there";
}

TEST(ExploreGrid, sums_the_log_odds_of_keyframes_and_clamps_them) {
  ExploreGrid grid(with_height(0.8));
  for (std::uint32_t k = 0; k < 6; ++k) {
    Scan s = standing_at(0.1, 0.1, 0.8);
    add_wall(s, 4.0, 1.0, 0.0, 2.0);
    // Two vehicles: their evidence is one sum.
    ASSERT_TRUE(grid.add(key(k, static_cast<std::uint16_t>(k % 2)), s.view()));
  }
  EXPECT_NEAR(grid.log_odds_at({4.1, 0.1}), 3.5, 1e-9);   // 6 * 0.85 = 5.1
  EXPECT_NEAR(grid.log_odds_at({2.1, 0.1}), -2.0, 1e-9);  // 6 * -0.4 = -2.4
  EXPECT_EQ(grid.keyframes(), 6U);
}

TEST(ExploreGrid, floor_rings_are_free_and_gaps_between_them_are_filled) {
  ExploreGrid grid(with_height(0.8));
  const Room hall{{0.0, 0.0, 0.0}, {30.0, 20.0, 8.0}, {}};
  ASSERT_TRUE(grid.add(key(0), look_around(hall, pose_at(15.0, 10.0, 0.8), 0.0).view()));
  const auto map = grid.picture();
  ASSERT_TRUE(map.has_value());
  int free = 0, others = 0;
  for (double x = 5.0; x < 25.0; x += 0.2) {
    for (double y = 1.0; y < 19.0; y += 0.2) {
      const auto state = map->at(map->cell_at({x, y}));
      free += state == CellState::kFree ? 1 : 0;
      others += state == CellState::kFree ? 0 : 1;
    }
  }
  EXPECT_EQ(others, 0) << free << " free";
  EXPECT_EQ(map->at(map->cell_at({15.0, 20.1})), CellState::kOccupied);
  EXPECT_EQ(map->at(map->cell_at({15.0, 21.0})), CellState::kUnknown);
}

TEST(ExploreGrid, a_ramp_is_free_and_a_wall_on_it_is_an_obstacle) {
  ExploreGrid grid(with_height(0.8));
  Scan s = standing_at(0.1, 0.1, 0.8);
  const double tan10 = std::tan(10.0 * std::numbers::pi / 180.0);
  for (double x = 1.0; x < 9.0; x += 0.4) {
    for (double y = -1.0; y <= 1.0; y += 0.2) s.add(x, y, -0.8 + std::max(0.0, x - 2.0) * tan10);
  }
  const double top_m = 7.0 * tan10;  // of the ramp at x = 9, 1.23 m above the vehicle's ground
  for (double y = -1.0; y <= 1.0; y += 0.1) {
    for (double z = 0.0; z < 2.0; z += 0.2) s.add(9.1, y, -0.8 + top_m + z);
  }
  ASSERT_TRUE(grid.add(key(0), s.view()));
  EXPECT_EQ(state_at(grid, 6.1, 0.1), CellState::kFree);
  EXPECT_EQ(state_at(grid, 9.2, 0.1), CellState::kOccupied);
}

TEST(ExploreGrid, a_step_is_an_obstacle_and_a_lintel_is_none) {
  ExploreGrid grid(with_height(0.8));
  Scan s = standing_at(0.1, 0.1, 0.8);
  for (double y = -1.0; y <= 1.0; y += 0.1) {
    for (double x = 1.0; x < 3.0; x += 0.2) s.add(x, y, -0.8);
    for (double x = 3.05; x < 4.0; x += 0.2) s.add(x, y, -0.6);       // 0.2 m at once
    for (double x = 1.5; x < 2.5; x += 0.2) s.add(x, y, -0.8 + 2.0);  // above the vehicle
  }
  ASSERT_TRUE(grid.add(key(0), s.view()));
  EXPECT_EQ(state_at(grid, 3.2, 0.1), CellState::kOccupied);
  EXPECT_NE(state_at(grid, 2.1, 0.1), CellState::kOccupied);
}

TEST(ExploreGrid, a_drop_is_detected_near_but_not_far_from_the_sensor) {
  for (const double edge_m : {2.0, 8.0}) {
    ExploreGrid grid(with_height(0.8));
    Scan s = standing_at(0.1, 0.1, 0.8);
    // Floor up to the edge, then 1 m deeper; the ray over the edge lands (0.8 + 1) / 0.8 as far.
    for (double y = -1.0; y <= 1.0; y += 0.05) {
      for (double x = 0.8; x < edge_m; x += 0.2) s.add(x, y, -0.8);
      s.add(edge_m * 1.8 / 0.8, y * 1.8 / 0.8, -1.8);
    }
    ASSERT_TRUE(grid.add(key(0), s.view()));
    const bool seen = grid.log_odds_at({edge_m + 0.1, 0.1}) > 0.0;
    EXPECT_EQ(seen, edge_m < 5.0 / 1.8 * 0.8);
  }
}

TEST(ExploreGrid, moving_a_keyframe_leaves_no_evidence_at_its_old_pose) {
  const Room room;
  ExploreGrid moved(ExploreSettings{}), right(ExploreSettings{});
  for (std::uint32_t k = 0; k < 5; ++k) {
    const Scan s = look_around(room, pose_at(6.0 + k, 5.0, 0.6, 0.2 * k), k, 360);
    Scan wrong = s;
    wrong.T_map_body = pose_at(8.0 + 3.0 * k, -4.0, 0.6, 1.0);
    ASSERT_TRUE(moved.add(key(k), wrong.view()));
    ASSERT_TRUE(right.add(key(k), s.view()));
  }
  for (std::uint32_t k = 5; k-- > 0;) {
    ASSERT_TRUE(moved.move(key(k), pose_at(6.0 + k, 5.0, 0.6, 0.2 * k)));
  }
  for (double x = -15.0; x < 40.0; x += 0.2) {
    for (double y = -25.0; y < 25.0; y += 0.2) {
      ASSERT_EQ(moved.log_odds_at({x, y}), right.log_odds_at({x, y})) << x << " " << y;
    }
  }
  ASSERT_TRUE(moved.remove(key(3)));
  EXPECT_FALSE(moved.remove(key(3)));
  EXPECT_FALSE(moved.move(key(3), pose_at(0, 0, 0)));
}

TEST(ExploreGrid, does_not_depend_on_the_order_of_keyframes) {
  const Room room;
  ExploreGrid a(with_height(0.6)), b(with_height(0.6));
  for (std::uint32_t k = 0; k < 6; ++k) {
    const auto scan = [&](std::uint32_t i) {
      return look_around(room, pose_at(4.0 + 2.0 * i, 5.0, 0.6), i, 360);
    };
    const Scan first = scan(k), last = scan(5 - k);
    a.add(key(k), first.view());
    b.add(key(5 - k), last.view());
  }
  const auto pa = a.picture(), pb = b.picture();
  ASSERT_TRUE(pa && pb);
  EXPECT_EQ(pa->cells, pb->cells);
}

TEST(ExploreGrid, a_vehicles_own_keyframe_clears_the_cells_where_it_was_seen) {
  ExploreGrid grid(with_height(0.6));
  Room room;
  room.cylinders.push_back({12.0, 5.0, 0.3, 1.0});  // another vehicle, standing
  for (std::uint32_t k = 0; k < 20; ++k) {
    const Scan s = look_around(room, pose_at(8.0, 5.0, 0.6), k, 720);
    grid.add(key(k), s.view());
  }
  EXPECT_EQ(state_at(grid, 11.75, 5.0), CellState::kOccupied);
  const Scan own = look_around(Room{}, pose_at(12.0, 5.0, 0.6), 0.0, 720);
  grid.add(key(0, 1), own.view());
  EXPECT_EQ(state_at(grid, 11.75, 5.0), CellState::kFree);
}

TEST(ExploreGrid, refuses_nan_poses_and_mismatched_scans_and_ignores_invalid_points) {
  ExploreGrid grid(with_height(0.8));
  Scan s = standing_at(0.0, 0.0, 0.8);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (int i = 0; i < 50; ++i) s.add(2.0 + 0.01 * i, 0.1 * i, 0.0);
  s.x_m[3] = nan;
  s.y_m[4] = std::numeric_limits<float>::infinity();
  s.z_m[5] = 1e30F;
  EXPECT_TRUE(grid.add(key(0), s.view()));
  Scan lost = s;
  lost.T_map_body.p.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(grid.add(key(1), lost.view()));
  Scan uneven = s;
  uneven.z_m.pop_back();
  EXPECT_FALSE(grid.add(key(2), uneven.view()));
  EXPECT_TRUE(grid.move(key(0), lost.T_map_body)) << "stays where it was";
  Scan far = s;
  far.T_map_body.p.x() = 1e12;
  grid.add(key(4), far.view());
  EXPECT_TRUE(grid.picture().has_value());
  EXPECT_EQ(grid.log_odds_at({1e300, 0.0}), 0.0);
}

TEST(ExploreGrid, reports_an_error_instead_of_growing_beyond_its_cell_limit) {
  ExploreSettings settings = with_height(0.8);
  settings.cells_max = 5e4;
  ExploreGrid grid(settings);
  for (std::uint32_t k = 0; k < 40; ++k) {
    Scan s = standing_at(50.0 * k, 0.0, 0.8);
    add_wall(s, 4.0, 1.0, 0.0, 2.0);
    grid.add(key(k), s.view());
  }
  EXPECT_TRUE(grid.is_full());
  const auto map = grid.picture();
  ASSERT_FALSE(map.has_value());
  EXPECT_EQ(map.error().code, ErrorCode::kMachine);
  EXPECT_FALSE(ExploreGrid(settings).picture().has_value());
}

}  // namespace
}  // namespace rali::map
