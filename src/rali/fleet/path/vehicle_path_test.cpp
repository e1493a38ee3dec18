#include "rali/fleet/path/vehicle_path.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "rali/fleet/path/shape.hpp"

namespace rali::fleet {
namespace {

using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;

Increment node(std::uint32_t number, const Vec3& p, double yaw_rad = 0.0) {
  Increment step;
  step.node = number;
  step.begins = number == 0;
  step.T_odom_body.p = p;
  step.T_odom_body.R = geometry::rotation_from_rpy(0.0, 0.0, yaw_rad);
  return step;
}

VehiclePath straight() {
  VehiclePath path(VehicleId{1});
  for (std::uint32_t k = 0; k < 4; ++k) {
    Increment step = node(k, {1.0 * k, 0.0, 0.0});
    if (k % 2 == 0) step.keyframe = k / 2;
    path.add(Time::from_s(k), step);
  }
  return path;
}

TEST(VehiclePath, order_of_arrival_and_repetition_change_nothing) {
  VehiclePath path(VehicleId{1});
  for (const std::uint32_t k : {2U, 0U, 3U, 1U, 2U, 0U}) {
    Increment step = node(k, {1.0 * k, 0.0, 0.0});
    if (k % 2 == 0) step.keyframe = k / 2;
    path.add(Time::from_s(k), step);
  }
  const VehiclePath ordered = straight();
  ASSERT_EQ(path.nodes().size(), 4U);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(path.nodes()[k].step->node, k);
    EXPECT_EQ(path.ties_to_before(k), ordered.ties_to_before(k));
  }
  EXPECT_EQ(path.node_of(1), 2U);
  EXPECT_FALSE(path.node_of(5).has_value());
}

TEST(VehiclePath, a_missing_node_cuts_the_inertial_chain_but_not_the_path) {
  VehiclePath path(VehicleId{1});
  path.add(Time::from_s(0), node(0, Vec3::Zero()));
  path.add(Time::from_s(2), node(2, {2.0, 0.0, 0.0}));
  EXPECT_FALSE(path.ties_to_before(1));
  ASSERT_TRUE(path.at(Time::from_s(1)).has_value());
  EXPECT_NEAR(path.at(Time::from_s(1))->T_odom_body.p.x(), 1.0, 1e-12);
}

TEST(VehiclePath, interpolates_on_the_arc_between_two_nodes) {
  // A quarter turn to the left with radius 1 m: halfway it is at 45 deg.
  VehiclePath path(VehicleId{1});
  path.add(Time::from_s(0), node(0, Vec3::Zero()));
  path.add(Time::from_s(1), node(1, {1.0, 1.0, 0.0}, std::numbers::pi / 2));
  const auto half = path.at(Time::from_s(0.5));
  ASSERT_TRUE(half.has_value());
  EXPECT_NEAR(half->T_odom_body.p.x(), std::sqrt(0.5), 1e-9);
  EXPECT_NEAR(half->T_odom_body.p.y(), 1.0 - std::sqrt(0.5), 1e-9);
  EXPECT_DOUBLE_EQ(half->alpha, 0.5);
}

TEST(VehiclePath, has_no_pose_outside_its_time_span_or_between_two_maps) {
  VehiclePath path = straight();
  Increment again = node(4, Vec3::Zero());
  again.begins = true;
  path.add(Time::from_s(10), again);
  EXPECT_FALSE(path.at(Time::from_s(-0.1)).has_value());
  EXPECT_FALSE(path.at(Time::from_s(10.1)).has_value());
  EXPECT_FALSE(path.at(Time::from_s(5)).has_value());
  EXPECT_TRUE(path.at(Time::from_s(3)).has_value());
  EXPECT_TRUE(path.at(Time::from_s(10)).has_value());
}

TEST(Shape, has_no_information_along_the_degenerate_direction_of_the_lidar) {
  ShapeSettings s;
  Mat6 seen = 1e8 * Mat6::Identity();
  seen(3, 3) = 0.0;
  SE3 T_before;
  T_before.R = geometry::rotation_from_rpy(0.0, 0.0, std::numbers::pi / 2);
  const Mat6 I = shape_information(seen, T_before, s);
  // The odom's x is the body's -y.
  EXPECT_NEAR(I(4, 4), 0.0, 1e-3);
  EXPECT_NEAR(I(3, 3), 1.0 / (s.shape_m * s.shape_m), 1.0);
}

// A scan also fits further along a bent tunnel, rotated by its bend: a longer step of the path must
// rotate with it, or the path leaves the tunnel.
TEST(Shape, leaves_a_degenerate_shift_free_only_with_its_coupled_yaw) {
  const ShapeSettings s;
  geometry::Vec6 open;
  open << 0.0, 0.0, 1e-3, 1.0, 0.0, 0.0;  // a metre along x is coupled with a milliradian of yaw
  const Mat6 full = 1e8 * Mat6::Identity();
  const geometry::Vec6 along = full * open;
  const Mat6 seen = full - along * along.transpose() / open.dot(along);
  const Mat6 I = shape_information(seen, SE3{}, s);
  EXPECT_NEAR(I(2, 2), 1.0 / (s.shape_rad * s.shape_rad), 1e4) << "the turn itself is known";
  EXPECT_LT(0.5 * open.dot(I * open), 1.0) << "a step of a metre that turns by the bend is free";
  geometry::Vec6 straight = open;
  straight[2] = 0.0;
  EXPECT_NEAR(straight.dot(I * straight), std::pow(1e-3 / s.shape_rad, 2), 0.5)
      << "one that does not is five sigma of its turn off";
}

TEST(Shape, yaw_sigma_of_a_degenerate_path_includes_the_bend_uncertainty) {
  const ShapeSettings s;
  const Mat6 seen = 1e8 * Mat6::Identity();
  double variance_rad2 = 0.0;
  Mat6 covariance = Mat6::Zero();
  for (int k = 0; k < 100; ++k) {
    const Mat6 before = covariance;
    covariance(3, 3) = std::pow(0.2 * (k + 1), 2);  // 20 m in the end
    const Mat6 I = shape_information(seen, SE3{}, s, unseen_variance_m2(before, covariance));
    variance_rad2 += 1.0 / I(2, 2);
  }
  EXPECT_NEAR(std::sqrt(variance_rad2), std::hypot(20.0 * s.bend_radpm, 10.0 * s.shape_rad), 1e-4);
  EXPECT_EQ(unseen_variance_m2(covariance, Mat6::Zero()), 0.0) << "ranges have taken it back";
}

}  // namespace
}  // namespace rali::fleet
