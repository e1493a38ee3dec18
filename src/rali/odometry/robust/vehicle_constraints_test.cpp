#include "rali/odometry/robust/vehicle_constraints.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/odometry/robust/patches_for_test.hpp"

namespace rali::odometry {
namespace {

using geometry::so3_exp;
using geometry::Vec3;

FilterState driving(double heading_rad, const Vec3& v_body) {
  FilterState s;
  s.T_odom_body.R = so3_exp(Vec3(0.0, 0.0, heading_rad));
  s.v = s.T_odom_body.R * v_body;
  s.P.diagonal().setConstant(1e-6);
  return s;
}

void drive_as_a_cart(VehicleConstraints& c, const PlaneMap& map, const Vec3& forward, int scans) {
  for (int k = 0; k < scans; ++k) {
    FilterState s = driving(0.05 * k, (k % 7 == 0 ? -0.8 : 1.2) * forward);  // also backwards
    s.T_odom_body.p = Vec3(0.4, 0.4, 1.0);
    c.update(s, Vec3::Zero(), map, true);
  }
}

const PlaneMap kNoMap{PlaneMapSettings{}};

TEST(VehicleConstraints, estimate_the_forward_axis_and_then_suppress_lateral_slip) {
  const Vec3 forward = Vec3(0.6, 0.8, 0.0);  // a sensor mounted at an angle
  VehicleConstraints c{ConstraintSettings{}};
  EXPECT_FALSE(c.non_holonomic_holds());
  drive_as_a_cart(c, kNoMap, forward, 100);
  ASSERT_TRUE(c.non_holonomic_holds());
  // Then the LiDAR is degenerate and the speed drifts sideways.
  const Vec3 side(-0.8, 0.6, 0.0);
  FilterState s = driving(0.7, 1.0 * forward + 0.3 * side);
  s.P.diagonal().segment<3>(kVel).setConstant(0.25);
  c.update(s, Vec3::Zero(), kNoMap, false);
  const Vec3 v_body = s.T_odom_body.R.transpose() * s.v;
  EXPECT_NEAR(v_body.dot(forward), 1.0, 0.01);  // along: untouched
  EXPECT_NEAR(v_body.dot(side), 0.0, 0.01);
  const geometry::Mat3 P_v =
      s.T_odom_body.R.transpose() * s.P.block<3, 3>(kVel, kVel) * s.T_odom_body.R;
  EXPECT_LT(std::sqrt(side.dot(P_v * side)), 0.051);
  EXPECT_NEAR(forward.dot(P_v * forward), 0.25, 0.01);
}

TEST(VehicleConstraints, do_not_change_a_velocity_with_small_covariance) {
  VehicleConstraints c{ConstraintSettings{}};
  drive_as_a_cart(c, kNoMap, Vec3::UnitX(), 100);
  ASSERT_TRUE(c.non_holonomic_holds());
  FilterState s = driving(0.0, Vec3(1.0, 0.04, 0.0));
  const FilterState before = s;
  c.update(s, Vec3::Zero(), kNoMap, false);
  EXPECT_EQ(s.v, before.v);
  EXPECT_EQ(s.P, before.P);
}

TEST(VehicleConstraints, allow_more_lateral_slip_while_turning) {
  VehicleConstraints c{ConstraintSettings{}};
  drive_as_a_cart(c, kNoMap, Vec3::UnitX(), 100);
  FilterState s = driving(0.0, Vec3(1.0, 0.1, 0.0));
  s.P.diagonal().segment<3>(kVel).setConstant(0.01);
  const FilterState before = s;
  c.update(s, Vec3(0.0, 0.0, 1.0), kNoMap, false);  // sigma 0.35 m/s: the filter is more certain
  EXPECT_EQ(s.v, before.v);
}

TEST(VehicleConstraints, suppress_motion_off_the_ground_while_turning_on_the_spot) {
  VehicleConstraints c{ConstraintSettings{}};
  for (int k = 0; k < 100; ++k) {  // tight curves: the sensor, ahead of the axle, moves sideways
    FilterState s =
        driving(0.05 * k, Vec3(0.5, k % 3 == 0 ? 0.2 : -0.2, k % 2 == 0 ? 0.02 : -0.02));
    c.update(s, Vec3(0.0, 0.0, 0.7), kNoMap, true);
  }
  EXPECT_FALSE(c.non_holonomic_holds());
  ASSERT_TRUE(c.on_ground());
  // Facing walls, the LiDAR sees neither floor nor ceiling.
  FilterState s = driving(0.7, Vec3(0.0, 0.1, 0.1));
  s.P.diagonal().segment<3>(kVel).setConstant(0.04);
  const FilterState before = s;
  c.update(s, Vec3(0.0, 0.0, 0.7), kNoMap, false, Vec3::UnitX().asDiagonal());
  EXPECT_EQ(s.v, before.v) << "the LiDAR observes the height";
  c.update(s, Vec3(0.0, 0.0, 0.7), kNoMap, false, Vec3::UnitZ().asDiagonal());
  EXPECT_NEAR(s.v.z(), 0.0, 0.005);
  EXPECT_LT(std::sqrt(s.P(kVel + 2, kVel + 2)), 0.03);
  EXPECT_NEAR((s.v - before.v).head<2>().norm(), 0.0, 1e-3) << "sideways it may move";
}

TEST(VehicleConstraints, allow_motion_off_the_ground_to_what_sways) {
  VehicleConstraints c{ConstraintSettings{}};
  for (int k = 0; k < 300; ++k) {  // a hand: 3.5 cm at 1.8 Hz
    FilterState s = driving(0.0, Vec3(1.2, 0.0, 0.4 * std::sin(0.1 * k)));
    c.update(s, Vec3::Zero(), kNoMap, true);
  }
  EXPECT_FALSE(c.on_ground());
}

TEST(VehicleConstraints, follow_a_ramp) {
  VehicleConstraints c{ConstraintSettings{}};
  const geometry::Mat3 ramp = so3_exp(Vec3(0.0, -0.15, 0.0));
  for (int k = 0; k < 100; ++k) {
    FilterState s = driving(0.0, Vec3(1.0, 0.0, 0.0));
    s.T_odom_body.R = ramp;
    s.v = ramp * Vec3(1.0, 0.0, 0.0);
    c.update(s, Vec3::Zero(), kNoMap, true);
  }
  ASSERT_TRUE(c.on_ground()) << "along the ramp, not level, is along the ground";
  FilterState s = driving(0.0, Vec3::Zero());
  s.T_odom_body.R = ramp;
  s.v = ramp * Vec3(1.0, 0.0, 0.1);
  s.P.diagonal().segment<3>(kVel).setConstant(0.04);
  c.update(s, Vec3::Zero(), kNoMap, false, Vec3::UnitZ().asDiagonal());
  EXPECT_NEAR(geometry::Vec3(ramp.transpose() * s.v).z(), 0.0, 0.01);
}

TEST(VehicleConstraints, are_never_enabled_for_motion_in_all_directions) {
  Rng rng(1, "drone");
  VehicleConstraints c{ConstraintSettings{}};
  for (int k = 0; k < 300; ++k) {
    FilterState s = driving(0.02 * k, 2.0 * Vec3(rng.normal(), rng.normal(), 0.5 * rng.normal()));
    c.update(s, Vec3::Zero(), kNoMap, true);
    EXPECT_FALSE(c.non_holonomic_holds() || c.on_ground()) << k;
  }
}

TEST(VehicleConstraints, are_disabled_when_the_vehicle_violates_them) {
  Rng rng(2, "lifted");
  VehicleConstraints c{ConstraintSettings{}};
  drive_as_a_cart(c, kNoMap, Vec3::UnitX(), 100);
  ASSERT_TRUE(c.non_holonomic_holds());
  for (int k = 0; k < 20; ++k) {  // carried by hand
    FilterState s = driving(0.0, Vec3(rng.normal(), rng.normal(), rng.normal()));
    c.update(s, Vec3::Zero(), kNoMap, true);
  }
  EXPECT_FALSE(c.non_holonomic_holds());
}

TEST(VehicleConstraints, are_not_enabled_by_slow_or_degenerate_motion) {
  VehicleConstraints c{ConstraintSettings{}};
  for (int k = 0; k < 300; ++k) {
    FilterState slow = driving(0.0, Vec3(0.1, 0.0, 0.0));
    c.update(slow, Vec3::Zero(), kNoMap, true);
    FilterState degenerate = driving(0.0, Vec3(2.0, 0.0, 0.0));
    c.update(degenerate, Vec3::Zero(), kNoMap, false);
  }
  EXPECT_FALSE(c.non_holonomic_holds());
}

PlaneMap floor_below() {
  PlaneMap map{PlaneMapSettings{}};
  insert_patch(map, {Vec3(0.4, 0.4, 0.3), Vec3::UnitZ()});
  return map;
}

TEST(VehicleConstraints, constrain_the_height_above_ground_when_the_scan_does_not) {
  const PlaneMap map = floor_below();
  VehicleConstraints c{ConstraintSettings{}};
  drive_as_a_cart(c, map, Vec3::UnitX(), 200);
  ASSERT_TRUE(c.ground_holds());
  FilterState s = driving(0.0, Vec3::UnitX());
  s.T_odom_body.p = Vec3(0.4, 0.4, 1.2);  // 20 cm too high by the filter's drift
  s.P.diagonal().segment<3>(kPos).setConstant(0.25);
  c.update(s, Vec3::Zero(), map, false);
  EXPECT_NEAR(s.T_odom_body.p.z(), 1.0, 0.02);
  EXPECT_NEAR(s.T_odom_body.p.x(), 0.4, 1e-3);
  EXPECT_LT(std::sqrt(s.P(kPos + 2, kPos + 2)), 0.065);
}

TEST(VehicleConstraints, do_not_measure_the_position_along_a_tunnel_by_the_slope_of_a_floor_plane) {
  PlaneMap map{PlaneMapSettings{}};
  insert_patch(map, {Vec3(0.4, 0.4, 0.3), Vec3(0.05, 0.0, 1.0).normalized()});  // 3 degrees off
  VehicleConstraints c{ConstraintSettings{}};
  drive_as_a_cart(c, map, Vec3::UnitX(), 200);
  ASSERT_TRUE(c.ground_holds());
  FilterState s = driving(0.0, Vec3::UnitX());
  s.T_odom_body.p = Vec3(0.6, 0.4, 1.0);
  s.P(kPos, kPos) = 4.0;
  const FilterState before = s;
  const geometry::Mat3 along = Vec3::UnitX().asDiagonal();
  c.update(s, Vec3::Zero(), map, false, along);
  EXPECT_EQ(s.T_odom_body.p, before.T_odom_body.p);
  EXPECT_EQ(s.P, before.P);
  c.update(s, Vec3::Zero(), map, false);
  EXPECT_LT(s.P(kPos, kPos), 2.5) << "the floor's slope, if the LiDAR observed the tunnel's axis";
}

TEST(VehicleConstraints, do_not_constrain_the_height_of_a_drone) {
  const PlaneMap map = floor_below();
  VehicleConstraints c{ConstraintSettings{}};
  for (int k = 0; k < 300; ++k) {
    FilterState s = driving(0.0, Vec3::UnitX());
    s.T_odom_body.p = Vec3(0.4, 0.4, 1.0 + 0.3 * std::sin(0.1 * k));
    c.update(s, Vec3::Zero(), map, true);
  }
  EXPECT_FALSE(c.ground_holds());
}

TEST(VehicleConstraints, can_be_switched_off) {
  ConstraintSettings off;
  off.non_holonomic = off.ground = false;
  const PlaneMap map = floor_below();
  VehicleConstraints c{off};
  drive_as_a_cart(c, map, Vec3::UnitX(), 200);
  FilterState s = driving(0.0, Vec3(1.0, 0.5, 0.0));
  s.T_odom_body.p = Vec3(0.4, 0.4, 1.2);
  s.P.diagonal().setConstant(1.0);
  const FilterState before = s;
  c.update(s, Vec3::Zero(), map, false);
  EXPECT_EQ(s.v, before.v);
  EXPECT_EQ(s.T_odom_body.p, before.T_odom_body.p);
}

}  // namespace
}  // namespace rali::odometry
