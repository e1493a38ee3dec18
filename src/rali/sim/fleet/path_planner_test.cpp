#include "rali/sim/fleet/path_planner.hpp"

#include <gtest/gtest.h>

#include "rali/sim/floor_plan/floor_plan.hpp"
#include "rali/sim/route.hpp"

namespace rali::sim {
namespace {

using geometry::Vec3;

/// Two rooms of 5 x 4 m with a door of 0.9 m at (5.1, 2).
TriangleMesh two_rooms() {
  FloorPlan plan;
  plan.areas = {{rectangle(0.0, 0.0, 5.0, 4.0), 2.6, 0.6},
                {rectangle(5.2, 0.0, 10.0, 4.0), 2.6, 0.6},
                {rectangle(5.0, 1.55, 5.2, 2.45), 2.1, 0.6}};
  return floor_plan_mesh(plan).value();
}

/// A room of 8 x 8 m; in its centre a closed box whose inside, 1.4 m wide, is floor too.
TriangleMesh room_with_a_closed_box() {
  FloorPlan plan;
  plan.areas = {{rectangle(0.0, 0.0, 8.0, 8.0), 2.6, 0.6}};
  TriangleMesh mesh = floor_plan_mesh(plan).value();
  for (const double side : {-0.85, 0.85}) {
    mesh.add_box({4.0 + side, 4.0, 0.0}, {0.3, 2.0, 1.0}, 0.0, 0.5);
    mesh.add_box({4.0, 4.0 + side, 0.0}, {2.0, 0.3, 1.0}, 0.0, 0.5);
  }
  return mesh;
}

/// True if a vehicle on this path touches something.
bool touches(const TriangleMesh& mesh, const PlannedPath& path) {
  const Clearance clearance(mesh);
  const Route route(path.corners, path.rounding_m);
  for (double s = 0.0; s < route.length_m(); s += 0.05) {
    if (!clearance.free_at(route.point_at(s), {})) return true;
  }
  return false;
}

// Corners closer than 0.3 m to the vehicle were left out, and the straight line to the next corner
// cut the edge of the door: a vehicle that had stopped there could not leave again.
TEST(PathPlanner, finds_a_collision_free_path_from_positions_behind_a_door) {
  const TriangleMesh mesh = two_rooms();
  const Clearance clearance(mesh);
  VehicleShape shape;
  shape.radius_m = 0.36;
  const auto planner = PathPlanner::make(mesh);
  ASSERT_TRUE(planner.has_value());
  const std::vector<Vec3> goal = {{1.0, 1.0, 0.0}};
  int starts = 0;
  for (double x = 5.1; x < 6.0; x += 0.05) {
    for (double y = 1.4; y < 2.65; y += 0.05) {
      const Vec3 from(x, y, 0.0);
      if (!clearance.free_at(from, shape)) continue;
      ++starts;
      const auto path = planner->plan(from, goal, {});
      ASSERT_TRUE(path.has_value()) << from.transpose() << ": " << path.error().message();
      EXPECT_FALSE(touches(mesh, *path)) << from.transpose();
    }
  }
  EXPECT_GT(starts, 100);
}

// The nearest free position lies inside the box, where no path leads.
TEST(PathPlanner, moves_an_occupied_end_to_the_nearest_reachable_position) {
  const TriangleMesh mesh = room_with_a_closed_box();
  const auto planner = PathPlanner::make(mesh);
  ASSERT_TRUE(planner.has_value());
  const Vec3 outside(1.0, 1.0, 0.0);
  const Vec3 in_the_wall(3.2, 4.0, 0.0);  // 0.42 m to free space inside, 0.58 m outside
  const auto there = planner->plan(outside, std::vector<Vec3>{in_the_wall}, {});
  ASSERT_TRUE(there.has_value()) << there.error().message();
  EXPECT_FALSE(touches(mesh, *there));
  EXPECT_LT((there->corners.back() - in_the_wall).norm(), 0.7);
  const Vec3 beside(2.75, 4.0, 0.0);  // 0.25 m from the box, as by an estimation error
  const auto away = planner->plan(beside, std::vector<Vec3>{outside}, {});
  ASSERT_TRUE(away.has_value()) << away.error().message();
}

TEST(PathPlanner, reports_a_goal_without_a_path) {
  const auto planner = PathPlanner::make(room_with_a_closed_box());
  ASSERT_TRUE(planner.has_value());
  const auto path =
      planner->plan({1.0, 1.0, 0.0}, std::vector<Vec3>{{7.0, 7.0, 0.0}, {20.0, 20.0, 0.0}}, {});
  ASSERT_FALSE(path.has_value());
  EXPECT_EQ(path.error().code, ErrorCode::kNoAnswer);
}

}  // namespace
}  // namespace rali::sim
