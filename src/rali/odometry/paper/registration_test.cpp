#include "rali/odometry/paper/registration.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/geometry/so3.hpp"

namespace rali::odometry::paper {
namespace {

using geometry::SE3;
using geometry::Vec3;
using geometry::Vec6;

// Test T2 of the design.
TEST(PlaneResidual, agrees_with_the_numbers_worked_by_hand) {
  const SE3 T{geometry::so3_exp(Vec3(0.1, -0.2, 0.7)), Vec3(3.0, -1.0, 0.4)};
  const PlaneResidual r =
      plane_residual(T, Vec3(4.0, 2.0, -0.5), Vec3(1.0, 1.0, 1.0), Vec3(0.6, 0.8, 0.0));
  EXPECT_NEAR(r.r_m, 3.953059, 1e-6);
  EXPECT_LT((r.J.head<3>() - Vec3(-0.321917, 0.388069, -1.023060)).norm(), 1e-6);
  EXPECT_LT((r.J.tail<3>() - Vec3(0.6, 0.8, 0.0)).norm(), 1e-15);
}

TEST(PlaneResidual, jacobian_agrees_with_central_differences) {
  Rng rng(2);
  const auto random = [&rng] { return Vec3(rng.normal(), rng.normal(), rng.normal()); };
  for (int trial = 0; trial < 20; ++trial) {
    const SE3 T{geometry::so3_exp(random()), random()};
    const Vec3 p = 5.0 * random();
    const Vec3 q = random();
    const Vec3 n = random().normalized();
    const PlaneResidual r = plane_residual(T, p, q, n);
    for (int k = 0; k < 6; ++k) {
      Vec6 d = Vec6::Zero();
      d(k) = 1e-5;
      const double numeric = (plane_residual(geometry::boxplus(T, d), p, q, n).r_m -
                              plane_residual(geometry::boxplus(T, -d), p, q, n).r_m) /
                             2e-5;
      EXPECT_NEAR(r.J(k), numeric, 1e-8);
    }
  }
}

// Points on three walls of a corner, in the frame of the sensor at the origin.
struct Corner {
  PlanarFeatures features;
  std::vector<PointNormal> map;

  explicit Corner(bool with_x_wall = true) {
    for (int i = -10; i <= 10; ++i) {
      for (int j = -5; j <= 5; ++j) {
        const float a = 0.3F * static_cast<float>(i);
        const float b = 0.3F * static_cast<float>(j);
        add({a, 3.0F, b}, {0.0F, -1.0F, 0.0F});
        add({a, b, -1.5F}, {0.0F, 0.0F, 1.0F});
        if (with_x_wall) add({4.0F, a, b}, {-1.0F, 0.0F, 0.0F});
      }
    }
  }

  void add(const geometry::Vec3f& p, const geometry::Vec3f& n) {
    map.push_back({p, n});
    features.x_m.push_back(p.x());
    features.y_m.push_back(p.y());
    features.z_m.push_back(p.z());
    features.nx.push_back(n.x());
    features.ny.push_back(n.y());
    features.nz.push_back(n.z());
    features.turned.push_back(0);
  }

  [[nodiscard]] Submap submap() const {
    Submap out(0.4, 0.5, 20, 100);
    out.add_keyframe({}, map);
    out.select_near(Vec3::Zero());
    return out;
  }
};

TEST(Registration, converges_within_2_mm_in_a_corner) {
  const Corner corner;
  const Submap map = corner.submap();
  Registration registration{PaperSettings{}};
  SerialExecutor executor;
  const SE3 guess{geometry::so3_exp(Vec3(0.01, -0.02, 0.015)), Vec3(0.05, -0.08, 0.06)};
  const RegistrationResult r = registration.align(corner.features, {}, guess, false, map, executor);
  EXPECT_TRUE(r.matched);
  EXPECT_TRUE(r.converged);
  EXPECT_LT(r.T_odom_body.p.norm(), 2e-3);  // one percent of the guess is kept by design
  EXPECT_LT(geometry::so3_log(r.T_odom_body.R).norm(), 1e-3);
  EXPECT_LE(r.iterations, 10);
  EXPECT_EQ(static_cast<int>(registration.evidence().size()), r.matches);
}

TEST(Registration, keeps_the_guess_along_a_direction_without_planes) {
  const Corner corner(false);  // wall and floor: nothing along x
  const Submap map = corner.submap();
  Registration registration{PaperSettings{}};
  SerialExecutor executor;
  const SE3 guess{geometry::Mat3::Identity(), Vec3(0.05, -0.08, 0.06)};
  const RegistrationResult r = registration.align(corner.features, {}, guess, false, map, executor);
  EXPECT_TRUE(r.matched);
  EXPECT_NEAR(r.T_odom_body.p.x(), 0.05, 1e-9);
  EXPECT_LT(std::abs(r.T_odom_body.p.y()), 2e-3);
  EXPECT_LT(std::abs(r.T_odom_body.p.z()), 2e-3);
  EXPECT_LT(r.information(3, 3), 1e-6 * r.information(4, 4));
}

TEST(Registration, reports_unmatched_and_keeps_the_guess_without_features_or_map) {
  const Corner corner;
  const Submap map = corner.submap();
  const Submap empty(0.4, 0.5, 20, 100);
  Registration registration{PaperSettings{}};
  SerialExecutor executor;
  const SE3 guess{geometry::so3_exp(Vec3(0.3, 0.0, 0.0)), Vec3(1.0, 2.0, 3.0)};
  for (const bool with_features : {false, true}) {
    const RegistrationResult r =
        registration.align(with_features ? corner.features : PlanarFeatures{}, {}, guess, true,
                           with_features ? empty : map, executor);
    EXPECT_FALSE(r.matched);
    EXPECT_EQ(r.T_odom_body.p, guess.p);
    EXPECT_EQ(r.T_odom_body.R, guess.R);
    EXPECT_TRUE(registration.evidence().empty());
  }
}

// Scaling all weights must change neither the pose nor its information (finding F10).
TEST(Registration, does_not_depend_on_the_scale_of_the_weights) {
  const Corner corner;
  const Submap map = corner.submap();
  SerialExecutor executor;
  const SE3 guess{geometry::Mat3::Identity(), Vec3(0.02, -0.03, 0.02)};
  PaperSettings small;
  small.huber_m = 100.0;
  PaperSettings large = small;
  for (double& eta : large.eta) eta *= 2.0;
  Registration a{small};
  Registration b{large};
  const RegistrationResult ra = a.align(corner.features, {}, guess, false, map, executor);
  const RegistrationResult rb = b.align(corner.features, {}, guess, false, map, executor);
  EXPECT_LT((ra.T_odom_body.p - rb.T_odom_body.p).norm(), 1e-9);
  EXPECT_LT((ra.information - rb.information).norm(), 1e-6 * ra.information.norm());
}

TEST(Submap, averages_neighbours_with_normals_flipped_to_the_query_side) {
  Submap map(0.5, 1.0, 5, 100);
  const float c = std::cos(0.1F);
  const float s = std::sin(0.1F);
  map.add_keyframe({}, {{{1.0F, 0.1F, 0.0F}, {-c, s, 0.0F}},
                        {{1.1F, -0.1F, 0.0F}, {c, s, 0.0F}},  // the same plane seen from behind
                        {{0.9F, 0.0F, 0.1F}, {-1.0F, 0.0F, 0.0F}},
                        {{1.0F, 0.0F, 0.0F}, {0.0F, 0.0F, 1.0F}},     // another plane
                        {{1.6F, 0.0F, 0.0F}, {-1.0F, 0.0F, 0.0F}}});  // too far
  map.select_near(Vec3::Zero());
  LocalPlane plane;
  ASSERT_TRUE(map.plane_at(Vec3(1.0, 0.0, 0.0), Vec3(-1.0, 0.0, 0.0), plane));
  EXPECT_EQ(plane.neighbours, 3);
  EXPECT_LT((plane.centre_odom - Vec3(1.0, 0.0, 0.1 / 3.0)).norm(), 1e-6);
  EXPECT_LT((plane.n_odom - Vec3(-1.0, 0.0, 0.0)).norm(), 1e-6);
  EXPECT_FALSE(map.plane_at(Vec3(1.0, 0.0, 0.0), Vec3(0.0, 0.0, 1.0), plane)) << "only one";
  EXPECT_FALSE(map.plane_at(Vec3(5.0, 0.0, 0.0), Vec3(-1.0, 0.0, 0.0), plane));
  const double nan = std::nan("");
  EXPECT_FALSE(map.plane_at(Vec3(nan, 0.0, 0.0), Vec3(-1.0, 0.0, 0.0), plane));
}

std::vector<PointNormal> patch_at(float x) {
  std::vector<PointNormal> out;
  for (int k = 0; k < 5; ++k) {
    out.push_back({{x, 0.1F * static_cast<float>(k), 0.0F}, {-1.0F, 0.0F, 0.0F}});
  }
  return out;
}

TEST(Submap, uses_only_the_nearest_keyframes_and_drops_the_oldest) {
  Submap map(0.4, 0.5, 2, 3);
  for (int k = 0; k < 5; ++k)
    map.add_keyframe({geometry::Mat3::Identity(), Vec3(10.0 * k, 0, 0)}, patch_at(1.0F));
  EXPECT_EQ(map.keyframes(), 3U);
  EXPECT_EQ(map.forgotten(), 2U);
  map.select_near(Vec3(40.0, 0.0, 0.0));
  EXPECT_EQ(map.points(), 10U);
  LocalPlane plane;
  const Vec3 n(-1.0, 0.0, 0.0);
  EXPECT_TRUE(map.plane_at(Vec3(41.0, 0.2, 0.0), n, plane));
  EXPECT_TRUE(map.plane_at(Vec3(31.0, 0.2, 0.0), n, plane));
  EXPECT_FALSE(map.plane_at(Vec3(21.0, 0.2, 0.0), n, plane));
  map.select_near(Vec3(20.0, 0.0, 0.0));
  EXPECT_TRUE(map.plane_at(Vec3(21.0, 0.2, 0.0), n, plane));
  EXPECT_FALSE(map.plane_at(Vec3(1.0, 0.2, 0.0), n, plane)) << "forgotten";
  map.clear();
  EXPECT_FALSE(map.plane_at(Vec3(21.0, 0.2, 0.0), n, plane));
}

TEST(PointGrid, radius_search_agrees_with_brute_force_and_drops_invalid_points) {
  Rng rng(3);
  std::vector<PointNormal> points;
  for (int k = 0; k < 2000; ++k) {
    points.push_back(
        {Vec3(rng.uniform(-5, 5), rng.uniform(-5, 5), rng.uniform(-1, 1)).cast<float>(),
         geometry::Vec3f::Zero()});
  }
  points.push_back({geometry::Vec3f::Constant(std::nanf("")), geometry::Vec3f::Zero()});
  points.push_back({geometry::Vec3f::Constant(1e30F), geometry::Vec3f::Zero()});
  PointGrid grid;
  grid.build(points, 0.7F);
  EXPECT_EQ(grid.size(), 2000U);
  for (int trial = 0; trial < 100; ++trial) {
    const geometry::Vec3f q = Vec3(rng.uniform(-6, 6), rng.uniform(-6, 6), 0.0).cast<float>();
    int found = 0;
    grid.for_each_within(q, [&](const PointNormal&) { ++found; });
    int expected = 0;
    for (const PointNormal& p : points) expected += (p.p - q).squaredNorm() < 0.7F * 0.7F ? 1 : 0;
    ASSERT_EQ(found, expected);
  }
}

TEST(DegenerateTranslation, is_removed_without_changing_other_directions) {
  // Test T11: x with one rotation, (translation, rotation) [[10, 5], [5, 100]] becomes
  // [[0.25, 5], [5, 100]]; y is not touched.
  geometry::Mat6 I = geometry::Mat6::Zero();
  I(0, 0) = 100.0;
  I(3, 3) = 10.0;
  I(0, 3) = I(3, 0) = 5.0;
  I(4, 4) = 7.0;
  geometry::Vec6 b = geometry::Vec6::Zero();
  b[3] = 1.0;
  b[4] = 2.0;
  remove_translation(I, b, Vec3::UnitX());
  EXPECT_NEAR(I(3, 3), 0.25, 1e-9);
  EXPECT_NEAR(I(0, 3), 5.0, 1e-9);
  EXPECT_NEAR(I(0, 0), 100.0, 1e-9);
  EXPECT_NEAR(I(4, 4), 7.0, 1e-12);
  EXPECT_NEAR(b[3], 0.0, 1e-9) << "it pulled along x only";
  EXPECT_NEAR(b[4], 2.0, 1e-12);
}

TEST(DegenerateTranslation, is_the_weakest_direction_near_the_one_given_by_normals) {
  // Walls constrain the direction 2 degrees off y by 1e4, noise gives 10. If x itself were removed,
  // nothing of the walls would be left.
  const Vec3 wall(-std::sin(0.035), std::cos(0.035), 0.0);
  const Vec3 along(std::cos(0.035), std::sin(0.035), 0.0);
  geometry::Mat6 I = geometry::Mat6::Zero();
  I.topLeftCorner<3, 3>() = 100.0 * geometry::Mat3::Identity();
  I.bottomRightCorner<3, 3>() = 1e4 * wall * wall.transpose() + 10.0 * along * along.transpose();
  const auto weakest = weakest_translation(I, Vec3::UnitX());
  ASSERT_TRUE(weakest);
  EXPECT_NEAR(std::abs(weakest->dot(along)), 1.0, 1e-9);
  geometry::Vec6 b = geometry::Vec6::Zero();
  remove_translation(I, b, *weakest);
  EXPECT_NEAR(wall.dot(I.bottomRightCorner<3, 3>() * wall), 1e4, 1e-6);
  EXPECT_NEAR(along.dot(I.bottomRightCorner<3, 3>() * along), 0.0, 1e-9);
  EXPECT_FALSE(weakest_translation(I, Vec3::UnitY())) << "across: the normals are wrong";
}

}  // namespace
}  // namespace rali::odometry::paper
