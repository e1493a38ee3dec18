#include "rali/fleet/centre/upright.hpp"

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "rali/fleet/frames/yaw_pose.hpp"
#include "rali/places/world_for_test.hpp"

namespace rali::fleet {
namespace {

using geometry::SE3;
using geometry::Vec3;
namespace world = places::test;

/// A LiDAR without inertial data moves 4 m through a world, in an odom frame that is tilted.
VehiclePath carried(const world::World& w, const SE3& T_odom_world, bool levelled = false) {
  VehiclePath path(VehicleId{1});
  Rng rng(1, "sweeps");
  for (std::uint32_t k = 0; k < 5; ++k) {
    const world::Sensor sensor;
    const world::Scan scan = world::look(w, world::at(3.0 + k, 4.0, 0.0), rng, sensor);
    KeyframePoints points;
    points.keyframe = k;
    points.T_body_lidar.p.z() = sensor.height_m;
    points.points = PackedPoints(PointArrays{scan.x_m, scan.y_m, scan.z_m, {}});
    Increment step;
    step.node = k;
    step.keyframe = k;
    step.begins = k == 0;
    step.levelled = levelled;
    step.T_odom_body = T_odom_world * scan.T_world_body;
    path.add(Time::from_s(k), step);
    path.add(Time::from_s(k), points);
  }
  return path;
}

/// The path of the given points, in one keyframe.
VehiclePath path_of(const std::vector<Vec3>& p) {
  VehiclePath path(VehicleId{1});
  Increment step;
  step.keyframe = 0;
  step.begins = true;
  path.add(Time::from_s(0), step);
  KeyframePoints points;
  PointArrays arrays;
  for (const Vec3& at : p) {
    arrays.push_back(static_cast<float>(at.x()), static_cast<float>(at.y()),
                     static_cast<float>(at.z()));
  }
  points.points = PackedPoints(arrays);
  path.add(Time::from_s(0), points);
  return path;
}

SE3 tilted(double roll_deg, double pitch_deg) {
  return {geometry::rotation_from_rpy(roll_deg * kDegree, pitch_deg * kDegree, 0.4), {3, -1, 2}};
}

std::optional<Vec3> up_of(const VehiclePath& path) {
  SerialExecutor executor;
  return up_by_surfaces(cut_into_submaps({&path, 1}, CutSettings{}, {}, executor));
}

double off_deg(const Vec3& a, const Vec3& b) {
  return std::acos(std::min(1.0, a.dot(b))) / kDegree;
}

TEST(Upright, finds_the_up_direction_for_a_lidar_tilted_by_20_deg) {
  for (const SE3& T : {tilted(20, 0), tilted(0, -20), tilted(14, 14), tilted(0, 0)}) {
    const auto up = up_of(carried(world::room(), T));
    ASSERT_TRUE(up);
    EXPECT_LT(off_deg(*up, T.R.col(2)), 0.5);
  }
}

// At 45 degrees a wall is as close to z of odom as the floor: any answer there would sometimes be
// wrong by 90 degrees.
TEST(Upright, finds_no_up_direction_for_a_lidar_tilted_by_45_deg) {
  const SE3 T = tilted(45, 0);
  const auto up = up_of(carried(world::room(), T));
  EXPECT_FALSE(up) << off_deg(*up, T.R.col(2));
}

TEST(Upright, finds_no_up_direction_from_rubble_or_from_walls_alone) {
  // Slopes in all directions: a heap of rubble defines no up direction.
  std::vector<Vec3> rubble;
  Rng rng(3, "rubble");
  for (int k = 0; k < 200; ++k) {
    const Vec3 middle(rng.uniform(-8, 8), rng.uniform(-8, 8), rng.uniform(-3, 3));
    const geometry::Mat3 R = geometry::rotation_from_rpy(
        rng.uniform(-3, 3), std::asin(rng.uniform(-1, 1)), rng.uniform(-3, 3));
    for (int i = 0; i < 60; ++i) {
      rubble.push_back(middle + R * Vec3(rng.uniform(-0.4, 0.4), rng.uniform(-0.4, 0.4), 0.0));
    }
  }
  EXPECT_FALSE(up_of(path_of(rubble)));
  // Two walls of a trench without any level surface.
  std::vector<Vec3> walls;
  for (double x = -8.0; x < 8.0; x += 0.2) {
    for (double z = -2.0; z < 2.0; z += 0.2) {
      walls.emplace_back(x, 2.0, z);
      walls.emplace_back(x, -2.0, z);
    }
  }
  EXPECT_FALSE(up_of(path_of(walls)));
}

TEST(Upright, finds_no_up_direction_without_points_or_from_nan) {
  EXPECT_FALSE(up_by_surfaces({}));
  EXPECT_FALSE(up_of(path_of({Vec3(1.0, 2.0, 3.0)})));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(up_of(path_of(std::vector<Vec3>(100, Vec3(nan, 1.0, nan)))));
}

TEST(Upright, does_not_level_paths_already_levelled_by_inertial_data) {
  SerialExecutor executor;
  const SE3 T = tilted(20, 0);
  const VehiclePath reported = carried(world::room(), T, true);
  EXPECT_TRUE(upright({&reported, 1}, CutSettings{}, {}, executor).empty());

  const std::vector<VehiclePath> both = {reported, carried(world::room(), T)};
  const std::vector<VehiclePath> mended = upright(both, CutSettings{}, {}, executor);
  ASSERT_EQ(mended.size(), 2U);
  EXPECT_EQ(mended[0].up_odom(), reported.up_odom());
  EXPECT_LT(off_deg(mended[1].up_odom(), T.R.col(2)), 0.5);
}

TEST(Upright, leaves_a_path_without_surfaces_unlevelled) {
  SerialExecutor executor;
  const VehiclePath path = path_of({Vec3(1.0, 2.0, 3.0)});
  EXPECT_TRUE(upright({&path, 1}, CutSettings{}, {}, executor).empty());
}

}  // namespace
}  // namespace rali::fleet
