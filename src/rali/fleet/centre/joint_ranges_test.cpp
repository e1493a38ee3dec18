#include "rali/fleet/centre/joint_ranges.hpp"

#include <gtest/gtest.h>

namespace rali::fleet {
namespace {

using geometry::SE3;
using geometry::Vec3;

VehiclePath path(std::uint16_t id, double y_m) {
  VehiclePath p(VehicleId{id});
  p.add(Time::from_s(0), EpochStart{"v", {Vec3(0.0, 0.0, 0.5)}});
  for (std::uint32_t k = 0; k < 11; ++k) {
    Increment step;
    step.node = k;
    step.begins = k == 0;
    step.T_odom_body.p = {1.0 * k, y_m, 0.0};
    p.add(Time::from_s(k), step);
  }
  return p;
}

RangeEntry entry(double t_s, std::uint16_t from, std::uint16_t to, const Vec3& p) {
  RangeEntry e;
  e.t = Time::from_s(t_s);
  e.from = VehicleId{from};
  e.to = VehicleId{to};
  e.range_m = 3.0;
  e.sigma_m = 0.1;
  e.T_odom_body.p = p;
  return e;
}

TEST(JointRanges, merges_one_exchange_reported_by_both_ends_into_one_range) {
  std::vector<VehiclePath> paths = {path(1, 0.0), path(2, 3.0)};
  RangeEntry by_2 = entry(2.5, 1, 2, {2.6, 3.0, 0.0});
  by_2.sigma_m = 0.3;
  paths[0].add(Time{}, RangeBlock{{entry(2.5, 1, 2, {2.4, 0.0, 0.0})}});
  paths[1].add(Time{}, RangeBlock{{by_2}});
  const JointRanges joint = join_ranges(paths);
  ASSERT_EQ(joint.ranges.size(), 1U);
  const JointRange& r = joint.ranges[0];
  EXPECT_EQ(r.a.p_odom_m, Vec3(2.4, 0.0, 0.5));
  EXPECT_EQ(r.b.p_odom_m, Vec3(2.6, 3.0, 0.5));
  EXPECT_EQ(r.a.place.node, 2U);
  EXPECT_DOUBLE_EQ(r.a.place.alpha, 0.5);
  // The larger sigma of the two ends is used.
  EXPECT_DOUBLE_EQ(r.sigma_m, 0.3);
}

TEST(JointRanges, takes_the_antenna_position_of_a_silent_end_from_its_path) {
  std::vector<VehiclePath> paths = {path(1, 0.0), path(2, 3.0)};
  paths[0].add(Time{}, RangeBlock{{entry(2.5, 2, 1, {2.4, 0.0, 0.0})}});
  const JointRanges joint = join_ranges(paths);
  ASSERT_EQ(joint.ranges.size(), 1U);
  EXPECT_NEAR(joint.ranges[0].b.p_odom_m.x(), 2.5, 1e-12);
}

TEST(JointRanges, skips_ranges_outside_a_path_or_with_unknown_vehicles_or_antennas) {
  std::vector<VehiclePath> paths = {path(1, 0.0), path(2, 3.0)};
  RangeEntry no_antenna = entry(3.0, 1, 2, Vec3::Zero());
  no_antenna.to_antenna = 4;
  paths[0].add(Time{},
               RangeBlock{{entry(99.0, 1, 2, Vec3::Zero()), no_antenna,
                           entry(3.0, 1, 7, Vec3::Zero()), entry(3.0, 1, 1, Vec3::Zero())}});
  const JointRanges joint = join_ranges(paths);
  EXPECT_TRUE(joint.ranges.empty());
  EXPECT_EQ(joint.without_pose, 2U);
}

TEST(JointRanges, drops_values_repeated_by_a_frozen_radio_while_driving) {
  std::vector<VehiclePath> paths = {path(1, 0.0), path(2, 3.0)};
  RangeBlock block;
  for (int k = 0; k < 5; ++k) {  // v1 drives at 1 m/s, v2 has reported nothing
    block.ranges.push_back(entry(3.0 + k, 1, 2, {3.0 + k, 0.0, 0.0}));
    if (k == 3) block.ranges.back().range_m = 3.001;
  }
  paths[0].add(Time{}, block);
  const JointRanges joint = join_ranges(paths);
  ASSERT_EQ(joint.ranges.size(), 3U);  // the first of each value
  EXPECT_DOUBLE_EQ(joint.ranges[1].range_m, 3.001);
}

TEST(JointRanges, keeps_repeated_values_at_standstill) {
  std::vector<VehiclePath> paths = {path(1, 0.0), path(2, 3.0)};
  RangeBlock block;
  RangeBlock of_2;
  for (int k = 0; k < 5; ++k) {
    block.ranges.push_back(entry(3.0 + 0.1 * k, 1, 2, {3.0, 0.0, 0.0}));
    of_2.ranges.push_back(entry(3.0 + 0.1 * k, 1, 2, {3.0, 3.0, 0.0}));
  }
  paths[0].add(Time{}, block);
  paths[1].add(Time{}, of_2);
  EXPECT_EQ(join_ranges(paths).ranges.size(), 5U);
}

}  // namespace
}  // namespace rali::fleet
