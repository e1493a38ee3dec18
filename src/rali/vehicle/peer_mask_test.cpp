#include "rali/vehicle/peer_mask.hpp"

#include <array>

#include <gtest/gtest.h>

namespace rali::vehicle {
namespace {

using geometry::SE3;
using geometry::Vec3;
using sensor::LidarScan;

const Vec3 kUp = Vec3::UnitZ();

LidarScan points(std::initializer_list<Vec3> all) {
  LidarScan scan;
  scan.t_begin = Time::from_s(1.0);
  scan.t_end = Time::from_s(1.1);
  scan.has_point_times = scan.has_rings = true;
  scan.rings = 16;
  scan.dropped_nan = 3;
  std::uint16_t ring = 0;
  for (const Vec3& p : all) {
    const Eigen::Vector3f f = p.cast<float>();
    scan.push_back(f.x(), f.y(), f.z(), 7.0F, 0.01F * static_cast<float>(ring), ring);
    ++ring;
  }
  return scan;
}

TEST(PeerMask, leaves_out_what_stands_around_the_antenna_and_nothing_else) {
  // The antenna is 10 m ahead and 0.5 m up; the wall is 2 m beside it, the roof 0.6 m above it.
  const std::array<Vec3, 1> antenna{Vec3(10.0, 0.0, 0.5)};
  const LidarScan scan = points({{9.5, 0.3, 0.2},      // on the vehicle
                                 {10.0, 2.0, 0.2},     // wall
                                 {10.0, 0.0, 1.1},     // roof
                                 {10.5, -1.0, -0.6},   // beside its wheels
                                 {10.0, 0.0, -0.8}});  // 1.3 m below
  const auto left = without_peers(scan, SE3{}, antenna, kUp, {});
  ASSERT_NE(left, nullptr);
  ASSERT_EQ(left->size(), 3U);
  EXPECT_FLOAT_EQ(left->y_m[0], 2.0F);
  EXPECT_FLOAT_EQ(left->z_m[1], 1.1F);
  EXPECT_FLOAT_EQ(left->z_m[2], -0.8F);
  EXPECT_EQ(left->ring[0], 1);
  EXPECT_FLOAT_EQ(left->dt_s[0], 0.01F);
  EXPECT_EQ(left->t_end, scan.t_end);
  EXPECT_EQ(left->dropped_nan, 3U);
}

TEST(PeerMask, copies_nothing_when_no_point_is_on_a_vehicle) {
  const std::array<Vec3, 1> antenna{Vec3(10.0, 0.0, 0.5)};
  EXPECT_EQ(without_peers(points({{1.0, 0.0, 0.0}, {5.0, 2.0, 0.3}}), SE3{}, antenna, kUp, {}),
            nullptr);
  EXPECT_EQ(without_peers(points({}), SE3{}, antenna, kUp, {}), nullptr);
}

TEST(PeerMask, knows_where_the_lidar_is_and_how_it_is_turned) {
  // The LiDAR at (10, 5) looks along -x: what is 3 m ahead of it is at (7, 5).
  const SE3 T_odom_lidar{geometry::so3_exp(Vec3(0.0, 0.0, 3.14159265358979)), {10.0, 5.0, 0.4}};
  const std::array<Vec3, 2> antennas{Vec3(-50.0, 0.0, 0.0), Vec3(7.0, 5.0, 0.6)};
  const auto left =
      without_peers(points({{3.0, 0.0, 0.0}, {-3.0, 0.0, 0.0}}), T_odom_lidar, antennas, kUp, {});
  ASSERT_NE(left, nullptr);
  ASSERT_EQ(left->size(), 1U);
  EXPECT_FLOAT_EQ(left->x_m[0], -3.0F);
}

}  // namespace
}  // namespace rali::vehicle
