#include "rali/degeneracy/walls.hpp"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace rali::degeneracy {
namespace {

using geometry::Mat3;
using geometry::Vec3;
using geometry::Vec6;

PlaneEvidence part(const Vec3& n, const Vec3& at_m, double residual_m = 0.0) {
  PlaneEvidence out;
  out.n_odom = n;
  out.lever_odom_m = at_m;
  out.weight = 1000.0;
  out.normal_covariance = 1e-4 * (Mat3::Identity() - n * n.transpose());
  out.residual_m = residual_m;
  return out;
}

/// Three parts of a wall across x, side by side; every second normal points the other way.
std::vector<PlaneEvidence> wall(double at_m, double residual_m) {
  std::vector<PlaneEvidence> out;
  for (int k = 0; k < 3; ++k) {
    const double sign = k % 2 == 0 ? 1.0 : -1.0;
    out.push_back(part(sign * Vec3::UnitX(), Vec3(at_m, 0.8 * k, 1.0), sign * residual_m));
  }
  return out;
}

Vec6 motion(double yaw_radpm = 0.0) {
  Vec6 out = Vec6::Zero();
  out(2) = yaw_radpm;
  out(3) = 1.0;
  return out;
}

WallHold held(const std::vector<PlaneEvidence>& planes, double yaw_radpm = 0.0) {
  return walls_facing(motion(yaw_radpm), planes, Mat3::Identity());
}

TEST(Walls, of_a_corridor_say_what_their_parts_say_by_hand) {
  auto planes = wall(75.0, 0.02);
  planes.push_back(part(Vec3::UnitY(), Vec3(3.0, 1.0, 0.0), 0.5));  // a side wall: no part
  EXPECT_NEAR(held(planes).raw, 3000.0, 1e-9);
  EXPECT_NEAR(held(planes).residual_m, 0.02, 1e-12);
  const auto behind = wall(-70.0, 0.04);
  planes.insert(planes.end(), behind.begin(), behind.end());
  EXPECT_NEAR(held(planes).raw, 6000.0, 1e-9);
  EXPECT_NEAR(held(planes).residual_m, 0.03, 1e-12);
}

TEST(Walls, have_the_noise_of_their_own_normals_only) {
  // At 45 degrees: along = sqrt(1/2), variance 0.5e-4.
  std::vector<PlaneEvidence> planes;
  for (int k = 0; k < 3; ++k) {
    const Vec3 along_wall = 0.8 * k * Vec3(-std::sqrt(0.5), std::sqrt(0.5), 0.0);
    planes.push_back(
        part(Vec3(std::sqrt(0.5), std::sqrt(0.5), 0.0), Vec3(20.0, 0.0, 0.0) + along_wall));
  }
  planes.push_back(part(Vec3::UnitY(), Vec3(3.0, 1.0, 0.0)));  // a side wall
  EXPECT_NEAR(held(planes).raw, 3.0 * 500.0, 1e-9);
  EXPECT_NEAR(held(planes).noise, 3.0 * 1000.0 * 0.5e-4, 1e-9);
}

TEST(Walls, are_not_made_of_planes_that_face_the_motion_by_a_wrong_normal_each) {
  std::vector<PlaneEvidence> planes;
  for (int k = 0; k < 6; ++k) planes.push_back(part(Vec3::UnitX(), Vec3(5.0 * k, 2.0, 1.5)));
  EXPECT_EQ(held(planes).raw, 0.0) << "scattered";
  auto turned = wall(75.0, 0.0);
  turned[1].n_odom = Vec3(std::cos(0.5), std::sin(0.5), 0.0);
  EXPECT_EQ(held(turned).raw, 0.0) << "two parts, and one that is turned";
}

// A wall of a bend, 50 m ahead, faces the axis by half; moved along the bend it stays where it is.
TEST(Walls, of_a_bend_do_not_face_the_motion_along_it) {
  const double radius_m = 100.0;
  std::vector<PlaneEvidence> planes;
  for (int k = 0; k < 5; ++k) {
    const double angle = 0.5 + 0.008 * k;
    const Vec3 out(std::sin(angle), -std::cos(angle), 0.0);  // from the centre at (0, radius)
    planes.push_back(part(out, Vec3(0.0, radius_m, 0.0) + (radius_m + 2.0) * out));
  }
  EXPECT_GT(held(planes).raw, 500.0) << "a shift";
  EXPECT_EQ(held(planes, 1.0 / radius_m).raw, 0.0) << "the screw";
}

}  // namespace
}  // namespace rali::degeneracy
