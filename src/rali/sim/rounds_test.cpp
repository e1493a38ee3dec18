#include "rali/sim/rounds.hpp"

#include <gtest/gtest.h>

namespace rali::sim {
namespace {

using geometry::Vec3;

World straight(double length_m) {
  World world;
  world.route = {Vec3::Zero(), Vec3(length_m, 0.0, 0.0)};
  world.free_width_m = 0.0;  // one lane
  return world;
}

TEST(Rounds, two_vehicles_on_30_m_alternate_in_legs_up_to_12_m) {
  const auto plan = plan_rounds(straight(30.0), 2);
  ASSERT_TRUE(plan) << plan.error().message();
  // Column: v1 at 2, v2 at 0. v2 stationary: v1 to 14. v1 stationary: v2 to 12. v1 to 26, v2 to 24,
  // v1 to the end, v2 two metres behind it.
  ASSERT_EQ(plan->starts.size(), 2U);
  EXPECT_NEAR(plan->starts[0].p_world_m.x(), 2.0, 1e-6);
  EXPECT_NEAR(plan->starts[1].p_world_m.x(), 0.0, 1e-6);
  const std::vector<double> ends{14.0, 12.0, 26.0, 24.0, 30.0, 28.0};
  ASSERT_EQ(plan->rounds.size(), ends.size());
  for (std::size_t k = 0; k < ends.size(); ++k) {
    const RoundPlan& round = plan->rounds[k];
    const std::size_t driver = k % 2;
    EXPECT_EQ(round.anchor, static_cast<int>(1 - driver)) << k;
    EXPECT_TRUE(round.routes[1 - driver].empty()) << k;
    ASSERT_EQ(round.routes[driver].size(), 2U) << k;
    EXPECT_NEAR(round.routes[driver].back().x(), ends[k], 1e-6) << k;
  }
}

TEST(Rounds, one_vehicle_drives_the_route_in_one_round_without_anchor) {
  const auto plan = plan_rounds(straight(30.0), 1);
  ASSERT_TRUE(plan);
  ASSERT_EQ(plan->rounds.size(), 1U);
  EXPECT_EQ(plan->rounds[0].anchor, -1);
  EXPECT_EQ(plan->rounds[0].routes[0].back().x(), 30.0);
}

TEST(Rounds, vehicles_keep_their_order_and_rounds_are_continuous) {
  for (const int vehicles : {2, 3, 5, 10}) {
    const auto plan = plan_rounds(straight(100.0), vehicles);
    ASSERT_TRUE(plan);
    std::vector<Vec3> at;
    for (const VehicleStart& start : plan->starts) at.push_back(start.p_world_m);
    for (const RoundPlan& round : plan->rounds) {
      ASSERT_GE(round.anchor, 0);
      for (std::size_t i = 0; i < at.size(); ++i) {
        if (round.routes[i].empty()) continue;
        EXPECT_NE(static_cast<int>(i), round.anchor);
        EXPECT_LT((round.routes[i].front() - at[i]).norm(), 1e-9);
        at[i] = round.routes[i].back();
      }
      for (std::size_t i = 1; i < at.size(); ++i) EXPECT_GE(at[i - 1].x() - at[i].x(), 1.9);
    }
    EXPECT_NEAR(at.front().x(), 100.0, 1e-6);
  }
}

TEST(Rounds, every_vehicle_is_anchor_at_least_twice) {
  const auto plan = plan_rounds(straight(100.0), 3);
  std::vector<int> times(3, 0);
  for (const RoundPlan& round : plan->rounds) ++times[static_cast<std::size_t>(round.anchor)];
  for (const int n : times) EXPECT_GE(n, 2);
}

TEST(Rounds, paths_too_short_for_the_column_are_refused) {
  const auto plan = plan_rounds(straight(5.0), 8);
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().what, "is 5.0 m long, too short for 8 vehicles in a column");
  EXPECT_FALSE(plan_rounds(World{}, 2));
}

TEST(Rounds, simplified_paths_keep_only_corners) {
  const std::vector<Vec3> points{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {2, 2, 0}};
  const std::vector<Vec3> corners{{0, 0, 0}, {2, 0, 0}, {2, 2, 0}};
  EXPECT_EQ(simplified(points, 0.01), corners);
}

}  // namespace
}  // namespace rali::sim
