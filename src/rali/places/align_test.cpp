#include "rali/places/align.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "rali/places/world_for_test.hpp"

namespace rali::places {
namespace {

using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;
using geometry::Vec6;
using test::at;
using test::path;

constexpr double kDegree = std::numbers::pi / 180.0;

double off_m(const SE3& a, const SE3& b) { return (a.p - b.p).norm(); }

double off_deg(const SE3& a, const SE3& b) {
  return geometry::so3_log(a.R.transpose() * b.R).norm() / kDegree;
}

TEST(align, finds_home_from_a_metre_and_ten_degrees_in_a_room) {
  Rng rng(1);
  const test::World world = test::room();
  const SE3 a = at(4.0, 4.0, 10.0), b = at(6.5, 3.5, 200.0);
  const Submap target = test::map_of(world, path(a, 3), rng);
  const Submap source = test::map_of(world, path(b, 3), rng);
  const SE3 truth = a.inverse() * b;
  for (int k = 0; k < 8; ++k) {
    SE3 start = truth;
    start.p += Vec3(std::cos(0.8 * k), std::sin(0.8 * k), 0.2);
    start.R = start.R * geometry::so3_exp(Vec3(0.0, 0.0, (k % 2 ? 10.0 : -10.0) * kDegree));
    const Registration r = align(target, source, start, AlignSettings{});
    EXPECT_TRUE(r.converged);
    EXPECT_TRUE(r.full_rank());
    EXPECT_LT(off_m(r.T_target_source, truth), 0.015);
    EXPECT_LT(off_deg(r.T_target_source, truth), 0.15);
    EXPECT_GT(r.overlap, 0.6);
    EXPECT_LT(r.rms_m, 0.02);
  }
}

TEST(align, knows_nothing_along_a_smooth_tunnel_and_stays_there) {
  Rng rng(2);
  const test::World world = test::tunnel();
  const SE3 a = at(0.0, 0.3, 2.0), b = at(4.0, -0.4, 185.0);
  const Submap target = test::map_of(world, path(a, 5), rng, 0.003);
  const Submap source = test::map_of(world, path(b, 5), rng, 0.003);
  const SE3 truth = a.inverse() * b;
  SE3 start = truth;
  start.p += Vec3(0.5, 0.3, 0.1);
  const Registration r = align(target, source, start, AlignSettings{});
  const Vec3 axis = a.R.transpose() * Vec3::UnitX();
  const Vec3 error = r.T_target_source.p - truth.p;
  EXPECT_FALSE(r.full_rank());
  EXPECT_EQ(r.directions[0].category, degeneracy::Category::kNone);
  EXPECT_LT((error - axis * error.dot(axis)).norm(), 0.02);
  EXPECT_NEAR(error.dot(axis), 0.5, 0.1);
}

}  // namespace
}  // namespace rali::places
