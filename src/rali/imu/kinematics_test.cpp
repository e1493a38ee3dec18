#include "rali/imu/kinematics.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace rali::imu {
namespace {

using geometry::so3_exp;
using geometry::so3_log;
using geometry::Vec3;

const Vec3 kRate_radps(0.0, 0.0, 0.5);
const Vec3 kForce_mps2(1.0, 0.0, 9.81);

// Test T1 of the design: 200 steps of 5 ms.
KinematicState turned(const Vec3& g) {
  KinematicState s;
  for (int k = 0; k < 200; ++k) integrate(s, kRate_radps, kForce_mps2, g, 0.005);
  return s;
}

// The same with the rotation at the start of each interval, as a regression might have it.
KinematicState turned_with_rotation_at_the_start() {
  KinematicState s;
  for (int k = 0; k < 200; ++k) {
    const Vec3 a = s.T_odom_body.R * kForce_mps2;
    s.T_odom_body.p += 0.005 * s.v_odom_mps + 0.5 * 0.005 * 0.005 * a;
    s.v_odom_mps += 0.005 * a;
    s.T_odom_body.R = s.T_odom_body.R * so3_exp(0.005 * kRate_radps);
  }
  return s;
}

const Vec3 kSpeed(0.958851, 0.244835, 9.81);

TEST(Kinematics, agrees_with_the_closed_form_of_a_constant_turn) {
  const KinematicState s = turned(Vec3::Zero());
  EXPECT_LT((so3_log(s.T_odom_body.R) - Vec3(0.0, 0.0, 0.5)).norm(), 1e-9);
  EXPECT_LT((s.v_odom_mps - kSpeed).norm(), 2e-6);
  EXPECT_LT((s.T_odom_body.p - Vec3(0.489670, 0.082298, 4.905)).norm(), 4e-6);
}

TEST(Kinematics, rotation_at_interval_start_would_err_by_over_1_mm_per_s) {
  const KinematicState wrong = turned_with_rotation_at_the_start();
  EXPECT_LT((wrong.v_odom_mps - Vec3(0.959157, 0.243636, 9.81)).norm(), 2e-6);
  EXPECT_GT((wrong.v_odom_mps - kSpeed).norm(), 1e-3);  // 600 times the tolerance above
}

TEST(Kinematics, adds_gravity_once) {
  const KinematicState s = turned(Vec3(0.0, 0.0, -9.81));
  EXPECT_NEAR(s.v_odom_mps.z(), 0.0, 1e-12);
  EXPECT_NEAR(s.T_odom_body.p.z(), 0.0, 1e-12);
  EXPECT_NEAR(s.v_odom_mps.x(), 0.958851, 2e-6);
}

TEST(Kinematics, falls_freely_in_a_parabola) {
  KinematicState s;
  s.v_odom_mps = Vec3(2.0, 0.0, 0.0);
  for (int k = 0; k < 10; ++k) {
    integrate(s, Vec3(0.3, -2.0, 1.0), Vec3::Zero(), Vec3(0.0, 0.0, -9.81), 0.1);
  }
  EXPECT_LT((s.T_odom_body.p - Vec3(2.0, 0.0, -4.905)).norm(), 1e-12);
  EXPECT_LT((s.v_odom_mps - Vec3(2.0, 0.0, -9.81)).norm(), 1e-12);
}

TEST(Kinematics, error_is_second_order_in_the_time_step) {
  // Halving the step must quarter the error, also with rate and force turning about other axes.
  const Vec3 w(0.7, -0.4, 0.9);
  const Vec3 a(1.0, 2.0, -3.0);
  const auto end_speed = [&](int steps) {
    KinematicState s;
    for (int k = 0; k < steps; ++k) integrate(s, w, a, Vec3::Zero(), 1.0 / steps);
    return s.v_odom_mps;
  };
  const Vec3 exact = geometry::so3_right_jacobian(-w) * a;  // integral of Exp(w t) a over 1 s
  const double coarse = (end_speed(10) - exact).norm();
  const double fine = (end_speed(20) - exact).norm();
  EXPECT_NEAR(coarse / fine, 4.0, 0.1);
  EXPECT_LT((end_speed(1000) - exact).norm(), 1e-6);
}

}  // namespace
}  // namespace rali::imu
