#include "rali/odometry/robust/view_planes.hpp"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/odometry/robust/plane_map.hpp"

namespace rali::odometry {
namespace {

using geometry::SE3;
using geometry::Vec3;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kHeight_m = 0.6;
constexpr double kHalfWidth_m = 3.0;

/// Points of 16 rings, two degrees apart, on the floor and the walls of a corridor along x.
std::vector<Vec3> corridor(double noise_m) {
  Rng rng(1, "rings");
  std::vector<Vec3> out;
  for (int ring = 0; ring < 16; ++ring) {
    const double up = (2.0 * ring - 15.0) * kDegree;
    for (int k = 0; k < 360; ++k) {
      const double turn = k * kDegree;
      const Vec3 ray(std::cos(up) * std::cos(turn), std::cos(up) * std::sin(turn), std::sin(up));
      double range_m = kHalfWidth_m / std::max(1e-9, std::abs(ray.y()));
      if (ray.z() < 0.0) range_m = std::min(range_m, kHeight_m / -ray.z());
      if (range_m < 40.0) out.push_back((range_m + noise_m * rng.normal()) * ray);
    }
  }
  return out;
}

TEST(ViewPlanes, find_the_floor_where_map_cells_contain_single_rings) {
  const std::vector<Vec3> points = corridor(0.02);
  const ViewPlanes scan(points, SE3{}, 0.0, {});
  PlaneMap map({});
  map.set_view(SE3{});
  for (int k = 0; k < 20; ++k) {
    for (const Vec3& p : points) map.insert(p, p.normalized().cast<float>(), 0.0);
  }
  // The rings at 3, 5 and 7 degrees meet the floor at 11.4, 6.9 and 4.9 m.
  const Vec3 ahead(6.9, 0.3, -kHeight_m);
  EXPECT_LT(map.find(ahead), 0);
  const int index = scan.find(ahead);
  ASSERT_GE(index, 0);
  const Plane& floor = scan.planes()[static_cast<std::size_t>(index)];
  EXPECT_GT(std::abs(floor.n.z()), std::cos(1.0 * kDegree));
  EXPECT_NEAR(floor.n.dot(ahead - floor.q), 0.0, 0.03);

  map.set_scan(scan);
  ASSERT_GE(map.find(ahead), 0);
  EXPECT_EQ(map.plane(map.find(ahead)).q, floor.q);
}

TEST(ViewPlanes, cells_with_two_surfaces_give_no_plane) {
  const ViewPlanes scan(corridor(0.0), SE3{}, 0.0, {});
  ASSERT_GT(scan.planes().size(), 50U);
  std::size_t turned = 0;
  for (const Plane& plane : scan.planes()) {
    const double along = plane.n.cwiseAbs().maxCoeff();
    EXPECT_GT(along, std::cos(10.0 * kDegree)) << plane.q.transpose();
    if (along < std::cos(3.0 * kDegree)) ++turned;
  }
  // A few points of the floor at the foot of a wall are within the flatness limit.
  EXPECT_LT(10 * turned, scan.planes().size());
}

TEST(ViewPlanes, are_discarded_after_0_5_m_or_10_degrees_of_motion) {
  const ViewPlanes scan({}, SE3{}, 0.0, {});
  EXPECT_FALSE(scan.is_left(SE3{geometry::so3_exp({0.0, 0.0, 0.1}), Vec3(0.4, 0.0, 0.0)}));
  EXPECT_TRUE(scan.is_left(SE3{geometry::Mat3::Identity(), Vec3(0.6, 0.0, 0.0)}));
  EXPECT_TRUE(scan.is_left(SE3{geometry::so3_exp({0.0, 0.0, 0.2}), Vec3::Zero()}));
  EXPECT_EQ(scan.find(Vec3(5.0, 0.0, 0.0)), -1);
  EXPECT_EQ(scan.find(Vec3::Zero()), -1);
}

TEST(ViewPlanes, of_the_next_scan_replace_those_of_the_last) {
  PlaneMap map({});
  map.set_scan(ViewPlanes(corridor(0.0), SE3{}, 0.0, {}));
  const std::size_t planes = map.plane_count();
  map.set_scan(ViewPlanes(corridor(0.0), SE3{}, 1.0, {}));
  EXPECT_EQ(map.plane_count(), planes);
  const int index = map.find({6.9, 0.3, -kHeight_m});
  ASSERT_GE(index, 0);
  EXPECT_EQ(map.plane(index).epoch, 1.0);
  map.set_scan(ViewPlanes({}, SE3{}, 2.0, {}));
  EXPECT_LT(map.find({6.9, 0.3, -kHeight_m}), 0);
}

}  // namespace
}  // namespace rali::odometry
