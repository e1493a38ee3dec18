#include "rali/vehicle/peer_mask.hpp"

#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "rali/vehicle/peer_places.hpp"

namespace rali::vehicle {
namespace {

using geometry::SE3;
using geometry::Vec3;
using sensor::LidarScan;

const Vec3 kUp = Vec3::UnitZ();

LidarScan points(std::initializer_list<Vec3> all) {
  LidarScan scan;
  scan.t_start = Time::from_s(1.0);
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

TEST(PeerMask, removes_only_points_around_the_antenna_of_a_peer) {
  // The antenna is 10 m ahead and 0.5 m up; the wall is 2 m beside it, the roof 0.6 m above it.
  const std::array<KnownLandmark, 1> antenna{KnownLandmark{Vec3(10.0, 0.0, 0.5)}};
  const LidarScan scan = points({{9.5, 0.3, 0.2},      // on the vehicle
                                 {10.0, 2.0, 0.2},     // wall
                                 {10.0, 0.0, 1.1},     // roof
                                 {10.5, -1.0, -0.6},   // beside its wheels
                                 {10.0, 0.0, -0.8}});  // 1.3 m below
  const auto left = without_peers(scan, SE3{}, SE3{}, antenna, {}, kUp, {});
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

TEST(PeerMask, makes_no_copy_if_no_point_is_on_a_vehicle) {
  const std::array<KnownLandmark, 1> antenna{KnownLandmark{Vec3(10.0, 0.0, 0.5)}};
  EXPECT_EQ(
      without_peers(points({{1.0, 0.0, 0.0}, {5.0, 2.0, 0.3}}), SE3{}, SE3{}, antenna, {}, kUp, {}),
      nullptr);
  EXPECT_EQ(without_peers(points({}), SE3{}, SE3{}, antenna, {}, kUp, {}), nullptr);
}

TEST(PeerMask, transforms_points_by_the_lidar_pose) {
  // The LiDAR at (10, 5) points along -x: what is 3 m ahead of it is at (7, 5).
  const SE3 T_odom_lidar{geometry::so3_exp(Vec3(0.0, 0.0, 3.14159265358979)), {10.0, 5.0, 0.4}};
  const std::array<KnownLandmark, 2> antennas{KnownLandmark{Vec3(-50.0, 0.0, 0.0)},
                                              KnownLandmark{Vec3(7.0, 5.0, 0.6)}};
  const auto left = without_peers(points({{3.0, 0.0, 0.0}, {-3.0, 0.0, 0.0}}), T_odom_lidar, SE3{},
                                  antennas, {}, kUp, {});
  ASSERT_NE(left, nullptr);
  ASSERT_EQ(left->size(), 1U);
  EXPECT_FLOAT_EQ(left->x_m[0], -3.0F);
}

/// Floor 0.9 m below the antenna and a wall 0.8 m beside it, both going on, and a box on the floor.
struct Parked {
  LidarScan scan = points({});
  std::size_t on_floor = 0;
  std::size_t on_wall = 0;
  std::size_t on_box = 0;

  /// @param slope of the floor along x
  explicit Parked(double slope) {
    const auto add = [this](const Vec3& p, std::size_t& n) {
      const Eigen::Vector3f f = p.cast<float>();
      scan.push_back(f.x(), f.y(), f.z(), 1.0F, 0.0F, 0);
      n += (p - Vec3(10.0, 0.0, p.z())).norm() < 1.2;
    };
    for (double x = 7.0; x < 13.0; x += 0.2) {
      const double rise = slope * (x - 10.0);
      for (double y = -3.0; y < 0.79; y += 0.2) add({x, y, -0.4 + rise}, on_floor);
      for (double z = -0.3; z < 1.5; z += 0.2) add({x, 0.8, z + rise}, on_wall);
    }
    for (double z = -0.3; z < 0.3; z += 0.1) {
      for (double a = -0.3; a < 0.31; a += 0.1) {
        add({9.7, a, z}, on_box);
        add({10.0 + a, -0.3, z}, on_box);
      }
    }
  }
};

TEST(PeerMask, keeps_floors_and_walls_that_extend_beyond_the_vehicle) {
  const std::array<KnownLandmark, 1> antenna{KnownLandmark{Vec3(10.0, 0.0, 0.5)}};
  for (const double slope : {0.0, 0.08}) {
    const Parked parked(slope);
    ASSERT_GT(parked.on_floor + parked.on_wall, 100U);
    const auto left = without_peers(parked.scan, SE3{}, SE3{}, antenna, {}, kUp, {});
    ASSERT_NE(left, nullptr);
    EXPECT_EQ(left->size(), parked.scan.size() - parked.on_box) << slope;
  }
}

TEST(PeerMask, does_not_mistake_the_side_of_a_vehicle_for_a_wall) {
  // It is 0.6 m off its estimated position: its front is outside.
  const std::array<KnownLandmark, 1> antenna{KnownLandmark{Vec3(10.0, 0.6, 0.5)}};
  LidarScan scan = points({});
  std::size_t inside = 0;
  for (double y = -0.9; y < 0.91; y += 0.05) {
    for (double z = -0.2; z < 0.21; z += 0.05) {
      scan.push_back(9.7F, static_cast<float>(y), static_cast<float>(z), 1.0F, 0.0F, 0);
      inside += std::hypot(0.3, y - 0.6) < 1.2;
    }
  }
  ASSERT_LT(inside, scan.size());
  const auto left = without_peers(scan, SE3{}, SE3{}, antenna, {}, kUp, {});
  ASSERT_NE(left, nullptr);
  EXPECT_EQ(left->size(), scan.size() - inside);
}

TEST(PeerMask, does_not_assign_nan_points_to_a_vehicle) {
  const std::array<KnownLandmark, 1> antenna{KnownLandmark{Vec3(10.0, 0.0, 0.5)}};
  const double nan = std::nan("");
  const auto left = without_peers(points({{nan, nan, nan}, {10.0, 0.0, 0.2}}), SE3{}, SE3{},
                                  antenna, {}, kUp, {});
  ASSERT_NE(left, nullptr);
  EXPECT_EQ(left->size(), 1U);
}

// Start poses are measured by tape: a body of 1.2 m around the wrong position left half of it in
// the scan.
TEST(PeerMask, widens_with_the_position_covariance_of_the_peer) {
  KnownLandmark place{Vec3(10.0, 0.0, 0.5)};
  const LidarScan scan = points({{11.5, 0.0, 0.3}, {12.5, 0.0, 0.3}});
  EXPECT_EQ(without_peers(scan, SE3{}, SE3{}, std::array{place}, {}, kUp, {}), nullptr)
      << "1.5 m beside it";
  place.covariance_m2.diagonal() << 0.25, 0.04, 4.0;  // along the line of sight; height is not used
  const auto left = without_peers(scan, SE3{}, SE3{}, std::array{place}, {}, kUp, {});
  ASSERT_TRUE(left);
  ASSERT_EQ(left->size(), 1U) << "within 1.2 m and 2 x 0.5 m";
  EXPECT_FLOAT_EQ(left->x_m[0], 12.5F);
}

TEST(PeerMask, removes_points_at_the_range_of_a_peer_of_unknown_direction) {
  // The own antenna is 0.4 m above the LiDAR; the other is 5 m away in an unknown direction.
  const ReceivedPeer peer{Vec3(0.0, 0.0, 0.4), 5.0};
  const std::array<Vec3, 6> all = {Vec3(5.2, 0.0, 0.2),    // ahead
                                   Vec3(0.0, -4.5, 0.0),   // beside: a wall, as far away
                                   Vec3(0.0, 0.0, 5.4),    // the roof: no vehicle is there
                                   Vec3(3.0, 0.0, 0.0),    // nearer
                                   Vec3(7.0, 0.0, 0.0),    // farther
                                   Vec3(4.9, 0.0, -1.2)};  // down a slope
  const LidarScan scan = points({all[0], all[1], all[2], all[3], all[4], all[5]});
  const auto left = without_peers(scan, SE3{}, SE3{}, {}, std::array{peer}, kUp, {});
  ASSERT_TRUE(left);
  ASSERT_EQ(left->size(), 3U);
  EXPECT_FLOAT_EQ(left->z_m[0], 5.4F);
  EXPECT_FLOAT_EQ(left->x_m[1], 3.0F);
  EXPECT_FLOAT_EQ(left->x_m[2], 7.0F);
  const ReceivedPeer far{Vec3::Zero(), 26.0};
  EXPECT_EQ(without_peers(scan, SE3{}, SE3{}, {}, std::array{far}, kUp, {}), nullptr);
}

}  // namespace
}  // namespace rali::vehicle
