#include "rali/degeneracy/support.hpp"

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace rali::degeneracy {
namespace {

using geometry::Mat3;
using geometry::Vec3;

PlaneEvidence plane(const Vec3& n, const Vec3& at_m, double tilt_sd = 0.02) {
  PlaneEvidence out;
  out.n_odom = n.normalized();
  out.lever_odom_m = at_m;
  out.normal_covariance =
      tilt_sd * tilt_sd * (Mat3::Identity() - out.n_odom * out.n_odom.transpose());
  out.weight = 1000.0;
  out.points = 3;
  return out;
}

TEST(Support, of_a_vehicle_ahead_is_several_planes_in_one_cluster) {
  std::vector<PlaneEvidence> planes;
  for (const double y : {-0.3, -0.1, 0.1, 0.3}) {
    planes.push_back(plane(-Vec3::UnitX(), Vec3(12.0, y, 0.2)));
  }
  for (int k = 0; k < 20; ++k) planes.push_back(plane(Vec3::UnitY(), Vec3(k, 2.5, 0.0)));
  const Support x = support_along(Vec3::UnitX(), planes, 1.5);
  EXPECT_EQ(x.planes, 4);
  EXPECT_EQ(x.clusters, 1);
  const Support y = support_along(Vec3::UnitY(), planes, 1.5);
  EXPECT_EQ(y.planes, 20);
  EXPECT_EQ(y.clusters, kClustersMax);  // a plane per metre: every second one starts a cluster
}

TEST(Support, of_a_corridor_end_wall_is_in_two_clusters) {
  std::vector<PlaneEvidence> planes;
  for (const double y : {-1.2, -0.4, 0.4, 1.2}) {
    planes.push_back(plane(-Vec3::UnitX(), Vec3(12.0, y, 0.2)));
  }
  const Support s = support_along(Vec3::UnitX(), planes, 1.5);
  EXPECT_EQ(s.planes, 4);
  EXPECT_EQ(s.clusters, 2);  // -1.2 and -0.4 m; 0.4 and 1.2 m, 1.6 m and more from the first
}

TEST(Support, excludes_planes_at_grazing_angles_or_within_normal_noise) {
  const auto tilted = [](double cosine) {
    return Vec3(cosine, std::sqrt(1.0 - cosine * cosine), 0.0);
  };
  const Vec3 at(1.0, 2.0, 0.0);
  const auto planes_of = [&](double cosine, double tilt_sd) {
    const std::vector<PlaneEvidence> one{plane(tilted(cosine), at, tilt_sd)};
    return support_along(Vec3::UnitX(), one, 1.5).planes;
  };
  EXPECT_EQ(planes_of(0.19, 0.001), 0);
  EXPECT_EQ(planes_of(0.21, 0.001), 1);
  // At 0.3 the sd of n.x is 0.954 tilt sd: three of these are 0.3 at a tilt sd of 0.1048.
  EXPECT_EQ(planes_of(0.30, 0.104), 1);
  EXPECT_EQ(planes_of(0.30, 0.106), 0);
}

TEST(Support, is_zero_without_planes_or_with_nan_normals) {
  EXPECT_EQ(support_along(Vec3::UnitX(), {}, 1.5).planes, 0);
  std::vector<PlaneEvidence> planes{plane(Vec3::UnitX(), Vec3::Zero())};
  planes[0].n_odom = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  const Support s = support_along(Vec3::UnitX(), planes, 1.5);
  EXPECT_EQ(s.planes, 0);
  EXPECT_EQ(s.clusters, 0);
}

}  // namespace
}  // namespace rali::degeneracy
