#include "rali/inspect/ground_normal.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/geometry/so3.hpp"

namespace rali::inspect {
namespace {

/// A floor 0.7 m below the LiDAR and a wall 4 m ahead, seen by a LiDAR turned by R_level_lidar.
sensor::LidarScan floor_and_wall(const geometry::Mat3& R_level_lidar) {
  sensor::LidarScan scan;
  Rng rng(2, "floor");
  for (int i = 0; i < 4000; ++i) {
    const bool floor = i % 2 == 0;
    const geometry::Vec3 p_level =
        floor ? geometry::Vec3{rng.uniform(-4, 4), rng.uniform(-4, 4), -0.7 + 0.01 * rng.normal()}
              : geometry::Vec3{4.0 + 0.01 * rng.normal(), rng.uniform(-4, 4), rng.uniform(-0.7, 2)};
    const geometry::Vec3f p = (R_level_lidar.transpose() * p_level).cast<float>();
    scan.push_back(p.x(), p.y(), p.z(), 0.0F, 0.0F, 0);
  }
  return scan;
}

TEST(GroundNormal, of_a_level_lidar_points_up) {
  const auto n = ground_normal(floor_and_wall(geometry::Mat3::Identity()));
  ASSERT_TRUE(n.has_value());
  EXPECT_GT(n->z(), 0.9999);
}

TEST(GroundNormal, of_a_lidar_pitched_by_20_deg_is_tilted) {
  const geometry::Mat3 R = geometry::rotation_from_rpy(0.0, 0.35, 0.0);
  const auto n = ground_normal(floor_and_wall(R));
  ASSERT_TRUE(n.has_value());
  EXPECT_GT(n->dot(R.transpose() * geometry::Vec3::UnitZ()), 0.9999);
}

TEST(GroundNormal, of_an_upside_down_lidar_points_down) {
  const auto n = ground_normal(floor_and_wall(geometry::rotation_from_rpy(3.14159, 0.0, 0.0)));
  ASSERT_TRUE(n.has_value());
  EXPECT_LT(n->z(), -0.999);
}

TEST(GroundNormal, without_points_or_without_a_plane_is_absent) {
  EXPECT_FALSE(ground_normal({}).has_value());
  sensor::LidarScan ball;
  Rng rng(3, "ball");
  for (int i = 0; i < 3000; ++i) {
    const geometry::Vec3 d{rng.normal(), rng.normal(), rng.normal()};
    const geometry::Vec3f p = (5.0 * d.normalized()).cast<float>();
    ball.push_back(p.x(), p.y(), p.z(), 0.0F, 0.0F, 0);
  }
  EXPECT_FALSE(ground_normal(ball).has_value());
}

}  // namespace
}  // namespace rali::inspect
