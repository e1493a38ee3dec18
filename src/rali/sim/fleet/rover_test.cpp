#include "rali/sim/fleet/rover.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/sim/internal/inertial_check.hpp"

namespace rali::sim {
namespace {

using geometry::Vec3;

Rover cart(std::uint64_t seed = 1) { return {MotionOptions(), {{0.0, 0.0, 0.0}, 0.0}, seed}; }

void drive(Rover& rover) {
  for (int i = 0; i < 100000 && !rover.idle(); ++i) rover.step();
}

TEST(Rover, turns_on_the_spot_and_reaches_the_end_of_its_path) {
  Rover rover = cart();
  rover.follow({{0.0, 0.0, 0.0}, {-6.0, 0.0, 0.0}, {-6.0, 4.0, 0.0}}, 1.0);
  double turned_m = 0.0;
  while (std::abs(rover.yaw_rad()) < 3.0) {  // the path begins behind it
    rover.step();
    turned_m = std::max(turned_m, rover.ground().norm());
  }
  EXPECT_LT(turned_m, 1e-6);
  drive(rover);
  EXPECT_TRUE(rover.standing());
  EXPECT_LT((rover.ground() - Vec3(-6.0, 4.0, 0.0)).norm(), 0.03);
}

TEST(Rover, motion_under_any_commands_is_reproduced_by_integrating_exact_imu_samples) {
  Rover rover = cart(3);
  const auto steps = [&](int n) {
    for (int i = 0; i < n; ++i) rover.step();
  };
  steps(50);
  rover.follow({{5.0, 1.0, 0.0}, {8.0, -3.0, 0.2}}, 1.0);
  steps(200);
  rover.hold(true);
  steps(150);
  EXPECT_TRUE(rover.standing());
  EXPECT_FALSE(rover.idle());
  rover.hold(false);
  steps(100);
  rover.halt();
  steps(150);
  EXPECT_TRUE(rover.idle());
  rover.follow({{0.0, 0.0, 0.0}}, 1.0);
  steps(300);
  const internal::Drift drift = internal::integrate(rover.trajectory(), 3.0, 10.0, 400.0);
  EXPECT_GT(drift.path_m, 5.0);
  EXPECT_LT(drift.position_m, 0.01);
  EXPECT_LT(drift.rotation_rad, 1e-3);
}

TEST(Rover, stops_within_its_predicted_stopping_distance) {
  Rover rover = cart();
  rover.follow({{20.0, 0.0, 0.0}}, 1.0);
  for (int i = 0; i < 250; ++i) rover.step();
  EXPECT_GT(rover.speed_mps(), 0.5);
  const Vec3 stop = rover.ground_ahead(rover.stopping_m());
  rover.halt();
  drive(rover);
  EXPECT_LT((rover.ground() - stop).norm(), 0.1);
}

TEST(Rover, has_lateral_velocity_below_0_08_mps) {
  Rover rover = cart(5);
  rover.follow({{4.0, 0.0, 0.0}, {4.0, 4.0, 0.0}, {0.0, 6.0, 0.0}}, 1.2);
  drive(rover);
  double lateral_m = 0.0;
  for (double t = 0.0; t < rover.trajectory().duration_s(); t += 0.05) {
    const MotionState s = rover.trajectory().at(t);
    const double yaw = geometry::rpy_from_rotation(s.T_world_body.R).z();
    lateral_m = std::max(lateral_m, std::abs(-std::sin(yaw) * s.v_world_mps.x() +
                                             std::cos(yaw) * s.v_world_mps.y()));
  }
  EXPECT_LT(lateral_m, 0.08);
}

TEST(Rover, ignores_a_path_that_ends_at_its_position) {
  Rover rover = cart();
  rover.follow({{0.08, 0.0, 0.0}}, 1.0);
  EXPECT_TRUE(rover.idle());
  rover.follow({}, 1.0);
  EXPECT_TRUE(rover.idle());
}

TEST(Rover, motion_of_handheld_and_drone_is_consistent_with_its_imu) {
  for (const Carrier carrier : {Carrier::kHandheld, Carrier::kDrone}) {
    MotionOptions o;
    o.carrier = carrier;
    Rover rover(o, {{0.0, 0.0, 0.0}, 0.0}, 1);
    for (int i = 0; i < 50; ++i) rover.step();
    EXPECT_LT(rover.trajectory().at(0.8).v_world_mps.norm(), 1e-9);
    rover.follow({{6.0, 0.0, 0.0}}, 1.0);
    drive(rover);
    const internal::Drift drift =
        internal::integrate(rover.trajectory(), 0.0, rover.trajectory().duration_s(), 400.0);
    EXPECT_LT(drift.position_m, 0.01);
    EXPECT_GT(rover.trajectory().pose_at(5.0).p.z(), 0.9);
  }
}

}  // namespace
}  // namespace rali::sim
