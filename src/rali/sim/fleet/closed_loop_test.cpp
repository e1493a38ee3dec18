#include "rali/sim/fleet/closed_loop.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/sim/internal/inertial_check.hpp"
#include "rali/sim/internal/test_fleet.hpp"

namespace rali::sim {
namespace {

using geometry::SE3;
using geometry::Vec3;
using internal::quiet_fleet;
using internal::room;

/// The test hall with a wall across it that has a door of 1.2 m.
World two_rooms() {
  World world = room(2);
  world.mesh.add_box({5.0, -3.8, 0.0}, {0.2, 6.4, 3.0}, 0.0, 0.6);
  world.mesh.add_box({5.0, 3.8, 0.0}, {0.2, 6.4, 3.0}, 0.0, 0.6);
  return world;
}

struct Goal {
  int vehicle;
  Vec3 place;  ///< world
};

/// Sends each round's vehicles to their goals and starts the next round when all have arrived. Its
/// map is rotated and shifted against the world; it uses exact poses.
class Script final : public FleetSoftware {
 public:
  Script(const FleetSimulation& simulation, std::vector<std::vector<Goal>> rounds)
      : simulation_(&simulation), rounds_(std::move(rounds)) {}

  void on_message(const FleetMessage& message) override {
    ++messages;
    if (const auto* imu = std::get_if<sensor::ImuSample>(&message.data)) {
      EXPECT_LE(imu->t, simulation_->t_end());
    }
  }

  std::vector<DriveCommand> decide(Time now, std::span<const DriveReport> vehicles) override {
    if (begun_ && !all_there(vehicles)) return {};
    if (begun_) {
      for (const Goal& goal : rounds_[round_]) {
        ends.push_back(simulation_->truth(goal.vehicle, now).state.T_world_body.p - goal.place);
      }
      ++round_;
    }
    begun_ = true;
    std::vector<DriveCommand> commands;
    if (finished()) return commands;
    for (const Goal& goal : rounds_[round_]) commands.push_back(command(goal, now));
    return commands;
  }

  bool finished() const override { return round_ >= rounds_.size(); }

  std::size_t messages = 0;
  std::vector<Vec3> ends;  ///< reached position minus goal of each drive
  std::vector<DriveStatus> states;

 private:
  bool all_there(std::span<const DriveReport> vehicles) {
    for (const Goal& goal : rounds_[round_]) {
      const DriveStatus s = vehicles[static_cast<std::size_t>(goal.vehicle)].status;
      if (s == DriveStatus::kDriving) return false;
      states.push_back(s);
    }
    return true;
  }

  DriveCommand command(const Goal& goal, Time now) const {
    const SE3 T_map_world{geometry::rotation_from_rpy(0.0, 0.0, 0.7), {3.0, -8.0, 1.0}};
    DriveCommand c;
    c.vehicle = goal.vehicle;
    c.places_map_m = {T_map_world * goal.place};
    c.T_map_body = T_map_world * simulation_->truth(goal.vehicle, now).state.T_world_body;
    c.t = now;
    return c;
  }

  const FleetSimulation* simulation_;
  std::vector<std::vector<Goal>> rounds_;
  std::size_t round_ = 0;
  bool begun_ = false;
};

std::unique_ptr<FleetSimulation> driven(World world, bool lidar) {
  FleetOptions o = quiet_fleet(2);
  o.scripted = false;
  o.vehicle.with_lidar = lidar;
  auto sim = make_fleet_simulation(std::move(world), o);
  EXPECT_TRUE(sim.has_value());
  return std::move(*sim);
}

TEST(ClosedLoop, vehicles_reach_the_goals_of_all_rounds_without_collision) {
  const auto sim = driven(two_rooms(), false);
  Script script(*sim, {{{1, {10.0, 3.0, 0.0}}},
                       {{0, {12.0, -4.0, 0.0}}},
                       {{0, {0.0, -2.0, 0.0}}, {1, {0.0, 4.0, 0.0}}}});
  const auto mission = run_closed_loop(*sim, script);
  ASSERT_TRUE(mission.has_value()) << mission.error().message();
  EXPECT_TRUE(mission->finished);
  ASSERT_EQ(script.ends.size(), 4U);
  for (const Vec3& end : script.ends) EXPECT_LT(end.head<2>().norm(), 0.3);
  for (const DriveStatus s : script.states) EXPECT_EQ(s, DriveStatus::kArrived);
  EXPECT_GT(script.messages, 5000U);
  EXPECT_GT(mission->path_m[0], 20.0);

  const Clearance clearance(sim->mesh());
  VehicleShape body;
  for (double t = 0.0; t < mission->duration_s; t += 0.1) {
    Vec3 ground[2];
    for (int v = 0; v < 2; ++v) {
      ground[v] = sim->motion().rover(v).trajectory().pose_at(t).p;
      ground[v].z() = 0.0;
      ASSERT_TRUE(clearance.free_at(ground[v], body)) << "vehicle " << v << " at " << t << " s";
    }
    ASSERT_GT((ground[0] - ground[1]).norm(), 0.6) << t << " s";
  }
  for (int v = 0; v < 2; ++v) {
    const Trajectory& path = sim->motion().rover(v).trajectory();
    for (double from = 0.0; from + 10.0 < mission->duration_s; from += 10.0) {
      const internal::Drift drift = internal::integrate(path, from, 10.0, 400.0);
      EXPECT_LT(drift.position_m, 0.01) << "vehicle " << v << " from " << from << " s";
    }
  }
}

TEST(ClosedLoop, inertial_samples_sent_while_driving_are_those_of_the_final_trajectory) {
  const auto sim = driven(two_rooms(), false);
  std::vector<sensor::ImuSample> sent;
  ClosedLoopOptions options;
  options.tap = [&](const FleetMessage& m) {
    const auto* imu = std::get_if<sensor::ImuSample>(&m.data);
    if (imu != nullptr && m.vehicle == 0) sent.push_back(*imu);
  };
  Script script(*sim, {{{0, {8.0, 2.0, 0.0}}}});
  ASSERT_TRUE(run_closed_loop(*sim, script, options).has_value());
  ASSERT_GT(sent.size(), 1000U);
  for (const sensor::ImuSample& s : sent) {
    const sensor::ImuSample exact = ideal_imu(s.t, sim->truth(0, s.t).state, SE3{});
    ASSERT_LT((s.accel_mps2 - exact.accel_mps2).norm(), 1e-6);
    ASSERT_LT((s.gyro_radps - exact.gyro_radps).norm(), 1e-6);
  }
}

TEST(ClosedLoop, a_standing_vehicle_on_the_path_is_bypassed) {
  World world = room(2);
  world.starts = {{{0.0, 0.0, 0.0}, 0.0}, {{4.0, 0.0, 0.0}, 0.0}};
  const auto sim = driven(world, false);
  Script script(*sim, {{{0, {9.0, 0.0, 0.0}}}});
  const auto mission = run_closed_loop(*sim, script);
  ASSERT_TRUE(mission.has_value());
  ASSERT_EQ(script.ends.size(), 1U);
  EXPECT_LT(script.ends[0].head<2>().norm(), 0.3);
}

TEST(ClosedLoop, a_goal_behind_a_blocking_vehicle_is_abandoned_within_45_s) {
  World world = room(2);
  // A passage of 1.4 m from wall to wall, blocked by the other vehicle.
  world.mesh.add_box({5.0, 3.85, 0.0}, {8.0, 6.3, 3.0}, 0.0, 0.6);
  world.mesh.add_box({5.0, -3.85, 0.0}, {8.0, 6.3, 3.0}, 0.0, 0.6);
  world.starts = {{{-2.0, 0.0, 0.0}, 0.0}, {{5.0, 0.0, 0.0}, 0.0}};
  const auto sim = driven(world, false);
  Script script(*sim, {{{0, {12.0, 0.0, 0.0}}}});
  const auto mission = run_closed_loop(*sim, script);
  ASSERT_TRUE(mission.has_value());
  ASSERT_EQ(script.states.size(), 1U);
  EXPECT_EQ(script.states[0], DriveStatus::kBlocked);
  EXPECT_LT(mission->duration_s, 45.0) << "10 s of them to drive there";
}

TEST(ClosedLoop, a_goal_without_a_path_is_reported_as_unreachable) {
  World world = room(2);
  world.mesh.add_box({5.0, 0.0, 0.0}, {0.2, 14.0, 3.0}, 0.0, 0.6);  // no door
  const auto sim = driven(world, false);
  Script script(*sim, {{{0, {10.0, 0.0, 0.0}}}});
  const auto mission = run_closed_loop(*sim, script);
  ASSERT_TRUE(mission.has_value());
  ASSERT_EQ(script.states.size(), 1U);
  EXPECT_EQ(script.states[0], DriveStatus::kUnreachable);
}

TEST(ClosedLoop, same_commands_give_identical_scans) {
  const auto bytes = [] {
    const auto sim = driven(two_rooms(), true);
    std::vector<float> out;
    ClosedLoopOptions options;
    options.end_s = 0.0;
    options.time_limit_s = 3.0;
    options.tap = [&](const FleetMessage& m) {
      const auto* scan = std::get_if<std::shared_ptr<const sensor::LidarScan>>(&m.data);
      if (scan != nullptr) out.insert(out.end(), (*scan)->x_m.begin(), (*scan)->x_m.begin() + 99);
    };
    Script script(*sim, {{{0, {8.0, 2.0, 0.0}}}});
    const auto mission = run_closed_loop(*sim, script, options);
    EXPECT_FALSE(mission->finished);  // stopped by the time limit
    return out;
  };
  EXPECT_EQ(bytes(), bytes());
}

/// Sends one invalid command.
class Wrong final : public FleetSoftware {
 public:
  explicit Wrong(DriveCommand command) : command_(std::move(command)) {}

  void on_message(const FleetMessage&) override {}

  std::vector<DriveCommand> decide(Time, std::span<const DriveReport>) override {
    return {command_};
  }

  bool finished() const override { return false; }

 private:
  DriveCommand command_;
};

TEST(ClosedLoop, invalid_commands_and_scripted_simulations_are_errors) {
  DriveCommand nobody;
  nobody.vehicle = 2;
  Wrong wrong(nobody);
  const auto sim = driven(room(2), false);
  const auto mission = run_closed_loop(*sim, wrong);
  ASSERT_FALSE(mission.has_value());
  EXPECT_NE(mission.error().message().find("vehicle 2 of 2"), std::string::npos);
  DriveCommand nowhere;
  nowhere.places_map_m = {{std::nan(""), 0.0, 0.0}};
  Wrong lost(nowhere);
  EXPECT_FALSE(run_closed_loop(*sim, lost).has_value());
  const auto scripted = make_fleet_simulation(room(2), quiet_fleet(2));
  ASSERT_TRUE(scripted.has_value());
  const auto refused = run_closed_loop(**scripted, wrong);
  ASSERT_FALSE(refused.has_value());
  EXPECT_NE(refused.error().message().find("script"), std::string::npos);
}

}  // namespace
}  // namespace rali::sim
