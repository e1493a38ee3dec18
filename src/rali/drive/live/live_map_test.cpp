#include "rali/drive/live/live_map.hpp"

#include <gtest/gtest.h>

#include "rali/fleet/centre/rounds_for_test.hpp"

namespace rali::drive {
namespace {

using fleet::FleetForTest;
using geometry::Vec3;

vehicle::PoseEstimate pose_of(std::size_t v, Time t, const fleet::Increment& step) {
  vehicle::PoseEstimate pose;
  pose.vehicle = FleetForTest::id(v);
  pose.t = t;
  pose.T_local_body = pose.T_odom_body = step.T_odom_body;
  pose.covariance = step.covariance;
  return pose;
}

/// A live map that receives the facts of a fleet of two as they are reported.
struct Received {
  explicit Received(const fleet::FleetKnowledge& known) : map(2, fleet::FleetSettings{}, known) {}

  void receive(const std::vector<fleet::Fact>& facts) {
    SerialExecutor executor;
    for (const fleet::Fact& fact : facts) {
      map.add(std::make_shared<const fleet::Fact>(fact));
      const auto* step = std::get_if<fleet::Increment>(&fact.body);
      if (step == nullptr) continue;
      map.advance(fact.t, executor);
      const vehicle::PoseEstimate pose = pose_of(fact.key.vehicle.value, fact.t, *step);
      const auto live = map.pose(pose);
      if (!live) continue;
      last[pose.vehicle.value] = live;
      if (const auto reported = map.step(pose, *live)) steps.push_back(*reported);
    }
  }

  LiveMap map;
  std::array<std::optional<LivePose>, 2> last;
  std::vector<FrameStep> steps;
  std::optional<Withdrawal> withdrawn;
};

TEST(LiveMap, a_vehicle_has_a_map_pose_once_a_prior_joins_it) {
  fleet::RoundsForTest options;
  options.vehicles = 2;
  options.step_sigma_m = 0.0;
  FleetForTest fleet(options);
  Received received(fleet.knowledge());
  for (int round = 0; round < 3; ++round) received.receive(fleet.round());
  ASSERT_TRUE(received.last[0] && received.last[1]);
  const Vec3 between = received.last[1]->T_map_body.p - received.last[0]->T_map_body.p;
  EXPECT_LT((between - (fleet.p_m(1) - fleet.p_m(0))).norm(), 0.2);
  EXPECT_GT(received.last[1]->covariance(3, 3), 0.0);
  ASSERT_FALSE(received.steps.empty());
  EXPECT_EQ(received.steps.front().reason, "joined");
}

TEST(LiveMap, a_vehicle_that_is_not_joined_has_no_map_pose) {
  fleet::RoundsForTest options;
  options.vehicles = 2;
  FleetForTest fleet(options);
  Received received{fleet::FleetKnowledge{}};
  std::vector<fleet::Fact> facts = fleet.round();
  std::erase_if(facts, [](const fleet::Fact& fact) {
    return !std::holds_alternative<fleet::Increment>(fact.body) &&
           !std::holds_alternative<fleet::EpochStart>(fact.body);
  });
  received.receive(facts);
  EXPECT_TRUE(received.last[0]);
  EXPECT_FALSE(received.last[1]);
}

// A start pose contradicted by ranges that come later: the first table uses it, later ones reject
// it.
TEST(LiveMap, a_vehicle_removed_from_the_table_is_withdrawn_with_its_interval) {
  fleet::RoundsForTest options;
  options.vehicles = 2;
  options.step_sigma_m = 0.0;
  FleetForTest fleet(options);
  fleet::FleetKnowledge known = fleet.knowledge();
  known.starts.front().T_relative_vehicle.p.x() += 8.0;
  Received received(known);
  Time t_last;
  for (int round = 0; round < 14 && !received.withdrawn; ++round) {
    std::vector<fleet::Fact> facts = fleet.round();
    if (round < 2) {
      std::erase_if(facts, [](const fleet::Fact& fact) {
        return std::holds_alternative<fleet::RangeBlock>(fact.body);
      });
    }
    t_last = facts.back().t;
    received.receive(facts);
    if (round == 1) {
      ASSERT_TRUE(received.last[1]);
      EXPECT_TRUE(received.map.take_withdrawals().empty());
    }
    for (const Withdrawal& w : received.map.take_withdrawals()) received.withdrawn = w;
  }
  ASSERT_TRUE(received.withdrawn);
  EXPECT_EQ(received.withdrawn->vehicle, FleetForTest::id(1));
  EXPECT_LT(received.withdrawn->t_joined, received.withdrawn->t_withdrawn);
  EXPECT_LE(received.withdrawn->t_withdrawn, t_last);
}

TEST(LiveMap, reports_shifts_of_the_map_pose_with_their_reason) {
  LiveMap map(1, fleet::FleetSettings{}, {});
  SerialExecutor executor;
  FleetForTest fleet({});
  for (const fleet::Fact& fact : fleet.round()) {
    if (fact.key.vehicle.value == 0) map.add(std::make_shared<const fleet::Fact>(fact));
  }
  map.advance(fleet.now(), executor);
  vehicle::PoseEstimate pose = pose_of(0, fleet.now(), {});
  const auto look = [&] { return map.step(pose, *map.pose(pose)); };
  EXPECT_EQ(look()->reason, "joined");
  EXPECT_FALSE(look()) << "nothing has moved";
  pose.T_local_body.p.x() += 0.5;  // a range: local moves, odom does not
  pose.range_from = FleetForTest::id(1);
  const auto step = look();
  ASSERT_TRUE(step);
  EXPECT_EQ(step->reason, "range");
  EXPECT_NEAR(step->shift_m, 0.5, 1e-9);
}

// After a stretch without ranges the filter shifts back by 20 m at once; the table follows later.
TEST(LiveMap, a_filter_correction_beyond_its_sigma_widens_covariance_and_solves_again) {
  constexpr int kRounds = 16;  // so many that the next table is not due for 6 s
  fleet::RoundsForTest options;
  options.vehicles = 2;
  FleetForTest fleet(options);
  Received received(fleet.knowledge());
  for (int round = 0; round < kRounds; ++round) received.receive(fleet.round());
  ASSERT_TRUE(received.last[1]);
  SerialExecutor executor;
  vehicle::PoseEstimate pose = pose_of(1, fleet.now(), {});
  const auto look = [&pose](LiveMap& map) {
    LivePose live = *map.pose(pose);
    static_cast<void>(map.step(pose, live));
    return live;
  };
  look(received.map);
  const LivePose before = look(received.map);
  EXPECT_FALSE(before.contradicted);
  LiveMap calm = received.map;      // receives the shifted pose only later
  pose.T_local_body.p.x() -= 20.0;  // local moves, odom does not
  const LivePose moved = look(received.map);
  EXPECT_TRUE(moved.contradicted);
  const geometry::Vec3 shift = moved.T_map_body.p - before.T_map_body.p;
  EXPECT_NEAR(shift.norm(), 20.0, 1e-6);
  EXPECT_GT(shift.normalized().dot(moved.covariance.bottomRightCorner<3, 3>() * shift),
            20.0 * 20.0);
  const Time later = pose.t + Duration::from_s(6.0);
  received.map.advance(later, executor);
  EXPECT_FALSE(look(received.map).contradicted) << "a new table, and the difference begins anew";
  calm.advance(later, executor);
  EXPECT_TRUE(look(calm).contradicted) << "without a contradiction no table is due yet";
}

// The gravity estimate improves with time: each table may rotate the map about its first pose.
TEST(LiveMap, position_sigma_far_from_the_origin_includes_the_tilt_sigma) {
  fleet::FleetSettings settings;
  settings.joint.tilt_deg = 0.573;  // 10 mrad
  LiveMap map(1, settings, {});
  SerialExecutor executor;
  FleetForTest fleet({});
  for (const fleet::Fact& fact : fleet.round()) {
    if (fact.key.vehicle.value == 0) map.add(std::make_shared<const fleet::Fact>(fact));
  }
  map.advance(fleet.now(), executor);
  vehicle::PoseEstimate pose = pose_of(0, fleet.now(), {});
  pose.covariance.setZero();
  const Vec3 origin_m = map.pose(pose)->T_map_body.p;
  pose.T_local_body.p.x() += 30.0;
  const auto live = map.pose(pose);
  const Vec3 p_m = live->T_map_body.p;
  ASSERT_GT((p_m - origin_m).norm(), 29.0);
  EXPECT_NEAR(live->covariance(5, 5), 1e-4 * p_m.head<2>().squaredNorm(), 1e-3);
  EXPECT_NEAR(live->covariance(2, 2), 0.0, 1e-9) << "heading is none of gravity's";
  // After a start in motion the vehicle's own gravity estimate is less certain.
  pose.level_sigma_rad = 0.03;
  EXPECT_NEAR(map.pose(pose)->covariance(5, 5), 1e-3 * p_m.head<2>().squaredNorm(), 1e-2);
}

// A start in motion mistakes acceleration for gravity: the map would be off by degrees.
TEST(LiveMap, waits_for_gravity_for_at_most_10_s) {
  LiveMap map(1, fleet::FleetSettings{}, {});
  SerialExecutor executor;
  FleetForTest fleet({});
  for (const fleet::Fact& fact : fleet.round()) {
    if (fact.key.vehicle.value == 0) map.add(std::make_shared<const fleet::Fact>(fact));
  }
  map.advance(fleet.now(), executor);
  vehicle::PoseEstimate pose = pose_of(0, fleet.now(), {});
  EXPECT_TRUE(map.pose(pose).has_value());
  pose.seeks_gravity = true;
  EXPECT_FALSE(map.pose(pose).has_value());
  pose.t = fleet.now() + Duration::from_s(10.1);
  EXPECT_TRUE(map.pose(pose).has_value());
}

}  // namespace
}  // namespace rali::drive
