#include "rali/fleet/centre/start_between.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace rali::fleet {
namespace {

using geometry::Vec3;

GivenStart start(int from, int to, const Vec3& p_m, double yaw_rad) {
  GivenStart out;
  out.relative_to = VehicleId{static_cast<std::uint16_t>(from)};
  out.vehicle = VehicleId{static_cast<std::uint16_t>(to)};
  out.T_relative_vehicle.p = p_m;
  out.T_relative_vehicle.R = geometry::rotation_from_rpy(0.0, 0.0, yaw_rad);
  out.sigma_m = 0.3;
  out.sigma_rad = 0.1;
  return out;
}

TEST(StartBetween, is_the_measured_start_pose_or_its_inverse) {
  // The second faces to the left of the first: the first is 3 m to its left.
  const std::vector<GivenStart> starts{start(1, 2, {3.0, 0.0, 0.0}, 0.5 * std::numbers::pi)};
  const auto there = start_between(starts, VehicleId{1}, VehicleId{2});
  const auto back = start_between(starts, VehicleId{2}, VehicleId{1});
  ASSERT_TRUE(there && back);
  EXPECT_LT((there->T_relative_vehicle.p - Vec3(3.0, 0.0, 0.0)).norm(), 1e-12);
  EXPECT_LT((back->T_relative_vehicle.p - Vec3(0.0, 3.0, 0.0)).norm(), 1e-12);
  for (const auto& s : {there, back}) {
    EXPECT_NEAR(s->sigma_m, 0.3, 1e-12);
    EXPECT_NEAR(s->sigma_rad, 0.1, 1e-12);
  }
}

TEST(StartBetween, composes_start_poses_of_two_vehicles_measured_from_a_third) {
  // A column: all are measured from the first, none from the second to the third.
  const std::vector<GivenStart> starts{start(1, 2, {-2.0, 0.0, 0.0}, 0.0),
                                       start(1, 3, {-4.0, 0.5, 0.0}, 0.0)};
  const auto s = start_between(starts, VehicleId{2}, VehicleId{3});
  ASSERT_TRUE(s);
  EXPECT_LT((s->T_relative_vehicle.p - Vec3(-2.0, 0.5, 0.0)).norm(), 1e-12);
  EXPECT_NEAR(s->sigma_m, std::hypot(0.3, 0.3), 1e-12);
  EXPECT_NEAR(s->sigma_rad, std::hypot(0.1, 0.1), 1e-12);
}

TEST(StartBetween, position_sigma_of_a_chain_includes_heading_times_lever_arm) {
  const std::vector<GivenStart> starts{start(2, 3, {5.0, 0.0, 0.0}, 0.0),
                                       start(1, 2, {2.0, 0.0, 0.0}, 0.0)};
  const auto s = start_between(starts, VehicleId{1}, VehicleId{3});
  ASSERT_TRUE(s);
  EXPECT_LT((s->T_relative_vehicle.p - Vec3(7.0, 0.0, 0.0)).norm(), 1e-12);
  EXPECT_NEAR(s->sigma_m, std::hypot(0.3, 0.3, 0.1 * 5.0), 1e-12);
}

TEST(StartBetween, is_empty_without_a_connecting_chain_and_takes_the_shortest_chain) {
  const std::vector<GivenStart> ring{start(1, 2, {1.0, 0.0, 0.0}, 0.0),
                                     start(2, 3, {1.0, 0.0, 0.0}, 0.0),
                                     start(3, 1, {-2.0, 0.0, 0.0}, 0.0)};
  EXPECT_FALSE(start_between(ring, VehicleId{1}, VehicleId{4}));
  EXPECT_FALSE(start_between({}, VehicleId{1}, VehicleId{2}));
  const auto short_path = start_between(ring, VehicleId{1}, VehicleId{3});
  ASSERT_TRUE(short_path);
  EXPECT_NEAR(short_path->sigma_m, 0.3, 1e-12) << "one step, not two";
}

}  // namespace
}  // namespace rali::fleet
