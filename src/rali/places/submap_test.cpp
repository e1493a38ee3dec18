#include "rali/places/submap.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "rali/places/descriptor.hpp"
#include "rali/places/fft.hpp"
#include "rali/places/hypotheses.hpp"
#include "rali/places/settings.hpp"
#include "rali/places/world_for_test.hpp"

namespace rali::places {
namespace {

using geometry::SE3;
using geometry::Vec3;
using geometry::Vec3f;
using test::at;
using test::path;

TEST(submap, refuses_empty_inconsistent_or_invalid_scans) {
  const SubmapSettings s;
  EXPECT_FALSE(make_submap({}, 0, s));
  std::vector<PosedScan> scans(1);
  EXPECT_FALSE(make_submap(scans, 1, s));
  EXPECT_FALSE(make_submap(scans, 0, s));  // no point
  const std::vector<float> one{1.0F}, two{1.0F, 2.0F};
  scans[0].scan.x_m = one;
  scans[0].scan.y_m = two;
  scans[0].scan.z_m = one;
  EXPECT_FALSE(make_submap(scans, 0, s));
  scans[0].scan.y_m = one;
  EXPECT_TRUE(make_submap(scans, 0, s));
  scans[0].T_odom_body.p.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(make_submap(scans, 0, s));
  scans[0].T_odom_body.p.x() = 1e30;
  EXPECT_FALSE(make_submap(scans, 0, s));
  scans[0].T_odom_body.p.x() = 0.0;
  scans[0].scan.up_body = Vec3::Zero();
  EXPECT_FALSE(make_submap(scans, 0, s));
}

TEST(submap, keeps_points_to_2_mm_or_coarser_if_they_are_far) {
  for (const float far_m : {40.0F, 400.0F}) {
    const std::vector<float> x{1.2345F, far_m, -3.3333F}, y{0.5F, 0.0F, 7.7777F}, z(3, 0.25F);
    std::vector<PosedScan> scans(1);
    scans[0].scan.x_m = x;
    scans[0].scan.y_m = y;
    scans[0].scan.z_m = z;
    SubmapSettings s;
    s.range_max_m = 500.0;
    const auto map = make_submap(scans, 0, s);
    ASSERT_TRUE(map);
    ASSERT_EQ(map->points(), 3U);
    const float step_m = std::max(0.002F, far_m / 32767.0F);
    for (std::size_t i = 0; i < 3; ++i) {
      const geometry::Vec3f p(x[i], y[i], z[i]);
      EXPECT_LE((map->point_m(i) - p).cwiseAbs().maxCoeff(), 0.51F * step_m) << far_m;
    }
  }
}

TEST(submap, drops_non_finite_and_far_points) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  const std::vector<float> x{1.0F, nan, inf, 1e20F, 2.0F}, y(5, 0.0F), z(5, 0.0F);
  std::vector<PosedScan> scans(1);
  scans[0].scan.x_m = x;
  scans[0].scan.y_m = y;
  scans[0].scan.z_m = z;
  const auto map = make_submap(scans, 0, SubmapSettings{});
  ASSERT_TRUE(map);
  ASSERT_EQ(map->points(), 2U);
  EXPECT_TRUE(map->planes().empty());
  EXPECT_TRUE(global_hypotheses(*map, *map, HypothesisSettings{}).ridges.empty());
  EXPECT_FALSE(recognise(*map, *map, RecogniseSettings{}).found());
}

TEST(submap, is_gravity_aligned_although_the_body_is_tilted) {
  Rng rng(1);
  SE3 T = at(4.0, 4.0, 40.0);
  T.R = T.R * geometry::so3_exp(Vec3(0.2, -0.15, 0.0));
  const Submap map = test::map_of(test::room(), {T}, rng);
  EXPECT_NEAR((map.T_ref_body().R * T.R.transpose() * Vec3::UnitZ()).z(), 1.0, 1e-9);
  EXPECT_NEAR(map.ground_z_m(), 0.0, 0.02);
}

TEST(planes, face_the_sensor_at_the_measured_position) {
  Rng rng(2);
  std::vector<Vec3f> points, rays;
  for (int k = 0; k < 100; ++k) {
    const Vec3 p(3.0 + 0.005 * rng.normal(), rng.uniform(0.0, 1.6), rng.uniform(0.0, 1.6));
    points.push_back(p.cast<float>());
    rays.push_back(p.normalized().cast<float>());
  }
  const std::vector<Plane> planes = planes_of(points, rays, PlaneSettings{});
  ASSERT_EQ(planes.size(), 1U);
  EXPECT_LT(planes[0].n.x(), -0.999);
  EXPECT_NEAR(planes[0].q_m.x(), 3.0, 0.003);
  EXPECT_TRUE(planes[0].is_wall());
}

TEST(planes, are_not_fitted_to_a_line_of_points) {
  std::vector<Vec3f> points, rays;
  for (int k = 0; k < 100; ++k) {
    points.emplace_back(0.016F * static_cast<float>(k), 0.5F, 0.5F);
    rays.emplace_back(0.0F, 0.0F, -1.0F);
  }
  EXPECT_TRUE(planes_of(points, rays, PlaneSettings{}).empty());
}

TEST(fft, of_an_impulse_has_the_expected_phases_and_inverts) {
  Fft2 fft(4);
  std::vector<Fft2::Complex> p(16);
  p[6] = {2.0F, 0.0F};  // row 1, column 2: phase (-i)^(ky) (-1)^(kx), transposed
  fft.forward(p);
  EXPECT_NEAR(p[0].real(), 2.0F, 1e-6F);
  EXPECT_NEAR(p[4].real(), -2.0F, 1e-6F);  // kx = 1, ky = 0
  EXPECT_NEAR(p[1].imag(), -2.0F, 1e-6F);  // kx = 0, ky = 1
  fft.back(p);
  EXPECT_NEAR(p[6].real(), 32.0F, 1e-5F);
  EXPECT_NEAR(std::abs(p[5]), 0.0F, 1e-5F);
}

TEST(hypotheses, contain_the_true_pose_of_a_room_and_a_corridor_ridge) {
  Rng rng(3);
  const SE3 a = at(4.0, 4.0, 10.0), b = at(6.5, 3.5, 200.0);
  const Submap target = test::map_of(test::room(), path(a, 3), rng);
  const Submap source = test::map_of(test::room(), path(b, 3), rng);
  const SE3 truth = a.inverse() * b;
  const Hypotheses h = global_hypotheses(target, source, HypothesisSettings{});
  ASSERT_FALSE(h.places.empty());
  EXPECT_LT((h.places[0].T_a_b.p - truth.p).norm(), 0.3);
  EXPECT_LT(std::abs(wrapped(yaw_of(h.places[0].T_a_b.R) - yaw_of(truth.R))), 0.05);
  const test::World corridor = test::corridor({});
  const Submap c = test::map_of(corridor, path(at(0.0, 0.0, 0.0), 7), rng);
  const Submap d = test::map_of(corridor, path(at(3.0, 0.2, 0.0), 7), rng);
  const Hypotheses along = global_hypotheses(c, d, HypothesisSettings{});
  ASSERT_FALSE(along.ridges.empty());
  EXPECT_GT(std::abs(along.ridges[0].direction_a.x()), 0.999);
  EXPECT_GT(along.ridges[0].to_m - along.ridges[0].from_m, 6.0);
}

TEST(descriptor, matches_after_a_90_degree_turn_and_reports_that_yaw) {
  Rng rng(4);
  const DescriptorSettings s;
  const Descriptor a = describe(test::map_of(test::room(), path(at(5.0, 4.0, 0.0), 1), rng), s);
  const Descriptor b = describe(test::map_of(test::room(), path(at(5.0, 4.0, 90.0), 1), rng), s);
  const Likeness like = compare(a, b);
  EXPECT_GT(like.score, 0.9);
  EXPECT_NEAR(like.yaw_rad, 1.5708, 0.06);
  PlaceIndex index(s);
  index.add({{0}, 1}, a);
  const auto all = [](KeyframeId) { return false; };
  ASSERT_EQ(index.query(b, all).size(), 1U);
  EXPECT_TRUE(index.query(b, [](KeyframeId) { return true; }).empty());
  EXPECT_TRUE(index.query(Descriptor{}, all).empty());
  index.add({{0}, 1}, Descriptor{});
  EXPECT_EQ(index.size(), 1U);
  EXPECT_TRUE(index.query(b, all).empty());
}

}  // namespace
}  // namespace rali::places
