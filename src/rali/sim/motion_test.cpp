#include "rali/sim/motion.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/sim/suspension.hpp"
#include "rali/sim/world.hpp"

namespace rali::sim {
namespace {

using geometry::Vec3;

/// Largest tilt [rad] between two times.
double tilt(const Trajectory& t, double from_s, double to_s) {
  double maximum = 0.0;
  for (double s = from_s; s <= to_s; s += 0.005) {
    const Vec3 rpy = geometry::rpy_from_rotation(t.pose_at(s).R);
    maximum = std::max({maximum, std::abs(rpy.x()), std::abs(rpy.y())});
  }
  return maximum;
}

TEST(Motion, a_start_in_motion_has_no_acceleration_or_rotation_peak) {
  const Route straight({{0, 0, 0}, {30, 0, 0}}, 1.0);
  MotionOptions o;
  o.standstill_s = 0.0;
  o.wander_m = 0.0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Trajectory t = make_trajectory(straight, o, seed);
    EXPECT_GT(t.at(0.0).v_world_mps.norm(), 0.3);
    // Before the first bump (2 m) the body is at rest on its springs.
    EXPECT_LT(tilt(t, 0.0, 1.0), 0.05) << "seed " << seed;
    EXPECT_LT(t.at(0.0).a_world_mps2.norm(), 1.5);
    EXPECT_LT(t.at(0.0).omega_body_radps.norm(), 0.1);
  }
}

// With the spline's last derivatives held, the gyroscope would turn while the body does not.
TEST(Motion, after_the_trajectory_end_velocity_and_acceleration_are_zero) {
  std::vector<Trajectory::Control> controls;
  for (int i = 0; i < 8; ++i) controls.push_back(0.1 * i * Trajectory::Control::Ones());
  const Trajectory trajectory(controls, 0.1);
  EXPECT_GT(trajectory.at(trajectory.duration_s()).omega_body_radps.norm(), 0.1);
  const MotionState after = trajectory.at(trajectory.duration_s() + 5.0);
  EXPECT_EQ(after.omega_body_radps.norm(), 0.0);
  EXPECT_EQ(after.v_world_mps.norm(), 0.0);
  EXPECT_EQ(after.a_world_mps2.norm(), 0.0);
  EXPECT_EQ(after.alpha_body_radps2.norm(), 0.0);
  EXPECT_EQ(after.T_world_body.p, trajectory.pose_at(trajectory.duration_s()).p);
}

TEST(Motion, body_tilts_under_acceleration_up_to_the_suspension_limit) {
  const World world = make_world(Scene::kLoop, 1);
  const Route route(world.route, world.rounding_m);
  MotionOptions o;
  const Trajectory normal = make_trajectory(route, o, 1);
  EXPECT_LT(tilt(normal, 0.0, 2.7), 1e-9);  // at rest
  EXPECT_GT(tilt(normal, 3.0, 20.0), 0.01);
  o.suspension = 3.0;
  o.acceleration_mps2 = 5.0;
  o.speed_factor = 5.0;
  const Trajectory wild = make_trajectory(route, o, 1);
  EXPECT_GT(tilt(wild, 0.0, wild.duration_s()), 0.1);
  EXPECT_LT(tilt(wild, 0.0, wild.duration_s()), 0.25);
}

TEST(Suspension, passes_small_jolts_and_limits_large_ones) {
  EXPECT_EQ(limited_jolt({0.02, 0.09, -0.09}), Vec3(0.02, 0.09, -0.09));
  const Vec3 large = limited_jolt({-5.0, 5.0, -5.0});
  EXPECT_NEAR((large - Vec3(-0.1, 0.2, -0.2)).norm(), 0.0, 1e-9);
}

TEST(Suspension, steering_rolls_the_body_and_braking_pitches_it) {
  Suspension left(1);
  left.settle({1.0, 0.0, 1.0, 0.0});
  const Vec3 lean = left.step(0.0, {1.0, 0.0, 1.0, 0.0}, 0.001);
  EXPECT_NEAR(lean.y(), 0.05, 0.003);  // outwards: the right side goes down in a left bend
  Suspension brake(1);
  brake.settle({1.0, -1.0, 0.0, 0.0});
  const Vec3 dip = brake.step(0.0, {1.0, -1.0, 0.0, 0.0}, 0.001);
  EXPECT_NEAR(dip.z(), 0.05, 0.003);  // nose down
  EXPECT_LT(dip.x(), -0.02);
}

TEST(Suspension, bumps_continue_over_2_km) {
  Bumps bumps(7);
  int hit = 0;
  for (double s = 0.0; s < 2000.0; s += 0.02) hit += bumps.at(s).x() > 0.0 ? 1 : 0;
  EXPECT_GT(hit, 500);
}

}  // namespace
}  // namespace rali::sim
