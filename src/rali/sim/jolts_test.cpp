#include "rali/sim/jolts.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/sim/fleet/rover.hpp"

namespace rali::sim {
namespace {

JoltOptions tiles() {
  JoltOptions o;
  o.joint_every_m = 0.4;
  o.joint_m = 0.003;
  o.slip_every_m = 0.2;
  o.slip_m = 0.002;
  o.step_s = 0.001;
  return o;
}

TEST(Jolts, without_options_give_no_offsets) {
  Jolts none(JoltOptions{}, 1);
  none.extend_to(10.0);
  EXPECT_TRUE(none.empty());
  EXPECT_EQ(none.at(5.0, 1.0).norm(), 0.0);
}

TEST(Jolts, slips_are_backwards_and_do_not_accumulate_to_drift) {
  Jolts jolts(tiles(), 3);
  jolts.extend_to(100.0);
  double minimum = 0.0;
  for (double s = 0.0; s < 100.0; s += 0.001) {
    const double x = jolts.at(s, 1.0)[0];
    EXPECT_LE(x, 1e-12);
    minimum = std::min(minimum, x);
  }
  EXPECT_LT(minimum, -0.003);
  EXPECT_GT(minimum, -0.02);
}

TEST(Jolts, a_step_is_shorter_than_one_imu_sample_interval) {
  Jolts jolts(tiles(), 3);
  jolts.extend_to(10.0);
  double largest = 0.0;
  constexpr double kSample_m = 0.005;  // at 1 m/s and 200 Hz
  for (double s = 0.0; s < 9.9; s += kSample_m) {
    largest = std::max(largest, (jolts.at(s + kSample_m, 1.0) - jolts.at(s, 1.0)).head<3>().norm());
  }
  EXPECT_GT(largest, 0.003);
}

TEST(Jolts, move_the_pose_but_not_the_smooth_acceleration) {
  MotionOptions o;
  o.wander_m = 0.0;
  o.suspension = 0.0;
  o.jolts = tiles();
  Rover jolted(o, {}, 1);
  o.jolts = {};
  Rover smooth(o, {}, 1);
  for (Rover* rover : {&jolted, &smooth}) {
    rover->follow({geometry::Vec3(8.0, 0.0, 0.0)}, 1.0);
    while (!rover->idle()) rover->step();
  }
  double apart_m = 0.0;
  for (double t = 0.0; t < smooth.trajectory().duration_s(); t += 0.003) {
    apart_m = std::max(
        apart_m, (jolted.trajectory().pose_at(t).p - smooth.trajectory().pose_at(t).p).norm());
    EXPECT_EQ(jolted.trajectory().at(t).a_world_mps2, smooth.trajectory().at(t).a_world_mps2);
  }
  EXPECT_GT(apart_m, 0.002);
  EXPECT_LT(apart_m, 0.02);
}

}  // namespace
}  // namespace rali::sim
