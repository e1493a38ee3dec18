#include "rali/sim/fleet/fleet_simulation.hpp"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "rali/sim/internal/test_fleet.hpp"

namespace rali::sim {
namespace {

using geometry::SE3;
using geometry::Vec3;
using internal::quiet_fleet;
using internal::room;

using ScanPtr = std::shared_ptr<const sensor::LidarScan>;

std::unique_ptr<FleetSimulation> make(World world, const FleetOptions& o) {
  auto sim = make_fleet_simulation(std::move(world), o);
  EXPECT_TRUE(sim.has_value()) << (sim ? "" : sim.error().message());
  return std::move(*sim);
}

/// All messages of one vehicle's recording, as numbers.
std::vector<double> trace(FleetSimulation& sim, int vehicle) {
  std::vector<double> out;
  while (const auto m = sim.next()) {
    if (m->vehicle != vehicle) continue;
    if (const auto* imu = std::get_if<sensor::ImuSample>(&m->data)) {
      out.push_back(imu->accel_mps2.x());
    } else if (const auto* scan = std::get_if<ScanPtr>(&m->data)) {
      for (std::size_t i = 0; i < (*scan)->size(); i += 37) {
        out.push_back(static_cast<double>((*scan)->x_m[i]));
      }
    } else if (const auto* range = std::get_if<sensor::RangeSample>(&m->data)) {
      out.push_back(range->range_m);
    }
  }
  return out;
}

/// Runs blocks in reverse: a dependence on their order would show.
class BackwardExecutor final : public Executor {
 public:
  void for_blocks(std::size_t n, std::size_t block,
                  const std::function<void(std::size_t, std::size_t, std::size_t)>& f) override {
    for (std::size_t index = (n + block - 1) / block; index-- > 0;) {
      f(index, index * block, std::min(n, (index + 1) * block));
    }
  }
};

TEST(FleetSimulation, messages_of_all_vehicles_come_in_order_of_arrival) {
  FleetOptions o = quiet_fleet(2);
  o.vehicle.duration_s = 1.0;
  const auto sim = make(room(2), o);
  Time last = sim->t_start();
  int scans[2] = {0, 0};
  int samples[2] = {0, 0};
  int ranges = 0;
  int readings = 0;
  while (const auto m = sim->next()) {
    Time t = last;
    if (const auto* imu = std::get_if<sensor::ImuSample>(&m->data)) {
      t = imu->t;
      ++samples[m->vehicle];
    } else if (const auto* scan = std::get_if<ScanPtr>(&m->data)) {
      EXPECT_GE((*scan)->t_end, last - Duration::from_s(0.01));
      ++scans[m->vehicle];
    } else if (const auto* range = std::get_if<sensor::RangeSample>(&m->data)) {
      EXPECT_EQ(range->from.value, 0);
      EXPECT_EQ(range->to.value, 1);
      t = range->t;
      ++ranges;
    } else {
      EXPECT_EQ(std::get<sensor::RadioSample>(m->data).to.value, m->vehicle);
      ++readings;
    }
    EXPECT_GE(t, last);
    last = t;
  }
  EXPECT_EQ(scans[0], 10);
  EXPECT_EQ(scans[1], 9);  // its LiDAR has its own phase
  EXPECT_EQ(samples[0], 201);
  EXPECT_EQ(samples[1], 200);
  EXPECT_EQ(ranges, 20);
  EXPECT_EQ(readings, 2);
}

TEST(FleetSimulation, the_order_of_ray_casting_does_not_change_the_output) {
  FleetOptions o = quiet_fleet(2);
  o.vehicle.ranging = LidarOptions();
  o.vehicle.pedestrians = 2;
  o.vehicle.duration_s = 0.5;
  const std::vector<double> one = trace(*make(room(2), o), 0);
  const auto other = make(room(2), o);
  BackwardExecutor backward;
  other->use(backward);
  EXPECT_EQ(one, trace(*other, 0));
}

TEST(FleetSimulation, additional_vehicles_do_not_change_the_imu_noise_of_the_first) {
  FleetOptions o = quiet_fleet(1);
  o.vehicle.imu = ImuOptions();
  o.vehicle.with_lidar = false;
  o.vehicle.duration_s = 0.4;
  const auto accel = [&](int vehicles) {
    o.vehicles = vehicles;
    std::vector<double> out;
    const auto sim = make(room(3), o);
    while (const auto m = sim->next()) {
      const auto* imu = std::get_if<sensor::ImuSample>(&m->data);
      if (imu != nullptr && m->vehicle == 0) out.push_back(imu->accel_mps2.y());
    }
    return out;
  };
  EXPECT_EQ(accel(1), accel(3));
}

TEST(FleetSimulation, a_moving_vehicle_is_scanned_at_its_pose_at_ray_time) {
  FleetOptions o = quiet_fleet(2);
  o.vehicle.duration_s = 5.0;
  const auto sim = make(room(2), o);  // vehicle 2 drives past vehicle 1, which is stationary
  int seen = 0;
  while (const auto m = sim->next()) {
    const auto* scan = std::get_if<ScanPtr>(&m->data);
    if (scan == nullptr || m->vehicle != 0) continue;
    for (std::size_t i = 0; i < (*scan)->size(); i += 5) {
      const Time t = (*scan)->t_start + Duration::from_s(static_cast<double>((*scan)->dt_s[i]));
      const Vec3 p((*scan)->x_m[i], (*scan)->y_m[i], (*scan)->z_m[i]);
      const SE3 T_world_lidar =
          sim->truth(0, t).state.T_world_body * sim->calibration_true(0).T_body_lidar;
      const Vec3 in_other = sim->truth(1, t).state.T_world_body.inverse() * (T_world_lidar * p);
      if (in_other.norm() > 0.6 || std::abs(in_other.z()) > 0.14) continue;
      ++seen;
      const double box = std::max(std::abs(in_other.x()) - 0.30, std::abs(in_other.y()) - 0.22);
      ASSERT_NEAR(box, 0.0, 2e-3) << "a point hangs beside the vehicle";
    }
  }
  EXPECT_GT(seen, 100);
}

TEST(FleetSimulation, the_anchor_stands_still_while_the_other_vehicle_drives) {
  FleetOptions o = quiet_fleet(2);
  o.pause_s = 4.0;  // until the suspension has settled
  const auto sim = make(room(2), o);
  ASSERT_EQ(sim->rounds().size(), 2U);
  for (const RoundTimes& round : sim->rounds()) {
    const int anchor = round.anchor;
    double driven = 0.0;
    Vec3 last = sim->truth(1 - anchor, sim->t_start() + Duration::from_s(round.start_s))
                    .state.T_world_body.p;
    for (double t = round.start_s; t < round.end_s; t += 0.1) {
      const Time time = sim->t_start() + Duration::from_s(t);
      EXPECT_LT(sim->truth(anchor, time).state.v_world_mps.norm(), 1e-3);
      const Vec3 p = sim->truth(1 - anchor, time).state.T_world_body.p;
      driven += (p - last).norm();
      last = p;
    }
    EXPECT_GT(driven, 4.0);
  }
  EXPECT_NEAR(sim->rounds()[1].start_s - sim->rounds()[0].end_s, o.pause_s, 0.03);
}

TEST(FleetSimulation, error_free_ranges_equal_the_distance_of_the_true_antennas) {
  FleetOptions o = quiet_fleet(2);
  o.vehicle.with_lidar = false;
  const auto sim = make(room(2), o);
  int count = 0;
  while (const auto m = sim->next()) {
    const auto* range = std::get_if<sensor::RangeSample>(&m->data);
    if (range == nullptr) continue;
    ++count;
    const auto antenna = [&](int v) {
      return sim->truth(v, range->t).state.T_world_body * sim->antennas(v)[0].p_true_m;
    };
    EXPECT_NEAR(range->range_m, (antenna(0) - antenna(1)).norm(), 1e-3);
  }
  EXPECT_GT(count, 100);
  EXPECT_NEAR((sim->antennas(0)[0].p_true_m - sim->antennas(0)[0].p_nominal_m).norm(),
              o.antenna_error_m, 1e-12);
  EXPECT_GT((sim->antennas(0)[0].p_nominal_m - sim->antennas(1)[0].p_nominal_m).norm(), 1e-3);
}

TEST(FleetSimulation, a_head_on_deadlock_is_an_error_with_its_round) {
  World world = room(2);
  const Vec3 here(0.0, 0.0, 0.0);
  const Vec3 there(6.0, 0.0, 0.0);
  RoundPlan round;
  round.routes.push_back({here, there});
  round.routes.push_back({there, here});
  world.rounds = {round};
  world.starts = {{here, 0.0}, {there, M_PI}};
  const auto sim = make_fleet_simulation(world, quiet_fleet(2));
  ASSERT_FALSE(sim.has_value());
  EXPECT_NE(sim.error().message().find("rounds[0]"), std::string::npos);
}

TEST(FleetSimulation, invalid_options_are_refused_by_name) {
  FleetOptions o = quiet_fleet(2);
  o.uwb.rate_hz = std::nan("");
  auto sim = make_fleet_simulation(room(2), o);
  ASSERT_FALSE(sim.has_value());
  EXPECT_NE(sim.error().message().find("rate_hz"), std::string::npos);
  o = quiet_fleet(4);
  sim = make_fleet_simulation(room(2), o);
  ASSERT_FALSE(sim.has_value());
  EXPECT_NE(sim.error().message().find("2 starts for 4"), std::string::npos);
}

TEST(FleetSimulation, vehicles_of_shipped_scenes_stay_0_7_m_apart_in_all_rounds) {
  for (const Scene scene : {Scene::kCorridor, Scene::kFloor, Scene::kLoop}) {
    const int vehicles = scene == Scene::kFloor ? 3 : 2;
    const auto world = world_for(make_world(scene, 1), vehicles);
    ASSERT_TRUE(world.has_value());
    const auto sim = make(*world, quiet_fleet(vehicles));
    for (Time t = sim->t_start(); t < sim->t_end(); t = t + Duration::from_s(0.2)) {
      for (int a = 0; a < vehicles; ++a) {
        for (int b = a + 1; b < vehicles; ++b) {
          const double apart =
              (sim->truth(a, t).state.T_world_body.p - sim->truth(b, t).state.T_world_body.p)
                  .norm();
          ASSERT_GT(apart, 0.7) << "scene " << static_cast<int>(scene);
        }
      }
    }
  }
}

}  // namespace
}  // namespace rali::sim
