#include "rali/eval/map_shape.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::eval {
namespace {

using geometry::Vec3;

/// Square of 0.6 m with normal noise of sigma_m, and a second sheet sheets_m away if > 0.
PointList patch(double sigma_m, double sheets_m, std::size_t n = 20000) {
  Rng rng(1, "patch");
  PointList points;
  for (std::size_t i = 0; i < n; ++i) {
    const double sheet = i % 2 == 0 ? 0.5 * sheets_m : -0.5 * sheets_m;
    points.emplace_back(rng.uniform(-0.3, 0.3), rng.uniform(-0.3, 0.3),
                        sheet + sigma_m * rng.normal());
  }
  return points;
}

// The listed figures are of one random draw; entropy varies between draws by a few hundredths.
TEST(PatchShape, of_1_and_3_cm_plates_has_the_expected_thickness_and_entropy) {
  const PatchShape thin = patch_shape(patch(0.01, 0.0));
  EXPECT_NEAR(thin.thickness_m, 0.0099, 2e-4);
  EXPECT_NEAR(thin.entropy, -3.856, 0.03);
  const PatchShape thick = patch_shape(patch(0.03, 0.0));
  EXPECT_NEAR(thick.thickness_m, 0.0298, 5e-4);
  EXPECT_NEAR(thick.entropy, -2.783, 0.04);
}

TEST(PatchShape, a_wall_doubled_by_10_cm_is_5_cm_thick_and_planar) {
  const PatchShape s = patch_shape(patch(0.01, 0.1));
  EXPECT_NEAR(s.thickness_m, 0.0511, 3e-4);
  EXPECT_NEAR(s.entropy, -2.218, 0.03);
  EXPECT_LT(s.flatness, MapShapeOptions{}.flatness_max);
}

TEST(PatchShape, matches_hand_computed_values_for_eight_points) {
  // Variances 4, 1 and 0.25: thickness 0.5, ln det = 0.
  PointList points;
  for (const double x : {-2.0, 2.0}) {
    for (const double y : {-1.0, 1.0}) {
      for (const double z : {-0.5, 0.5}) points.emplace_back(100.0 + x, y, z);
    }
  }
  const PatchShape s = patch_shape(points);
  EXPECT_NEAR(s.thickness_m, 0.5, 1e-12);
  EXPECT_NEAR(s.flatness, 0.25, 1e-12);
  EXPECT_NEAR(s.entropy, 1.5 * std::log(2.0 * 3.14159265358979 * 2.71828182845905), 1e-9);
}

/// Floor of 3 m by 3 m.
PointList floor_of(double sigma_m, double sheets_m) {
  Rng rng(2, "floor");
  PointList points;
  for (int i = 0; i < 3000; ++i) {
    const double sheet = i % 2 == 0 ? 0.5 * sheets_m : -0.5 * sheets_m;
    points.emplace_back(rng.uniform(0, 3), rng.uniform(0, 3), sheet + sigma_m * rng.normal());
  }
  return points;
}

TEST(MapShape, thickness_p95_and_entropy_reveal_a_doubled_surface) {
  SerialExecutor serial;
  MapShapeOptions options;
  options.thin_m = 0.0;
  const MapShape sharp = map_shape(floor_of(0.01, 0.0), options, serial);
  EXPECT_NEAR(sharp.thickness.median, 0.0099, 5e-4);
  EXPECT_LT(sharp.thickness_p95_m, 0.0115);
  ASSERT_TRUE(sharp.mme);
  const MapShape doubled = map_shape(floor_of(0.01, 0.1), options, serial);
  EXPECT_NEAR(doubled.thickness_p95_m, 0.0511, 3e-3);
  EXPECT_GT(*doubled.mme, *sharp.mme + 1.0);
}

TEST(MapShape, handles_empty_sparse_and_noise_free_clouds) {
  SerialExecutor serial;
  EXPECT_EQ(map_shape({}, {}, serial).points, 0U);
  const MapShape sparse =
      map_shape({Vec3(0, 0, 0), Vec3(9, 0, 0), Vec3(0, std::nan(""), 0)}, {}, serial);
  EXPECT_EQ(sparse.points, 2U);
  EXPECT_FALSE(sparse.mme);
  EXPECT_EQ(sparse.patches, 0U);
  const MapShape perfect = map_shape(floor_of(0.0, 0.0), {}, serial);
  EXPECT_NEAR(perfect.thickness.max, 0.0, 2e-6);
  EXPECT_TRUE(std::isfinite(*perfect.mme));
}

TEST(PointGrid, agrees_with_brute_force_radius_search) {
  Rng rng(4, "grid");
  PointList points;
  for (int i = 0; i < 2000; ++i) {
    points.emplace_back(rng.uniform(-3, 3), rng.uniform(-3, 3), rng.uniform(-1, 1));
  }
  const PointGrid grid(points, 0.4);
  for (int i = 0; i < 100; ++i) {
    const Vec3 p(rng.uniform(-4, 4), rng.uniform(-4, 4), rng.uniform(-2, 2));
    std::size_t all = 0, found = 0;
    for (const Vec3& q : points) all += (q - p).squaredNorm() <= 0.16 ? 1 : 0;
    grid.for_each_near(p, [&](std::uint32_t, double) { return ++found > 0; });
    EXPECT_EQ(found, all);
  }
}

TEST(Thinned, keeps_one_point_per_cube_without_position_bias) {
  Rng rng(6, "thin");
  PointList points;
  for (int i = 0; i < 20000; ++i)
    points.emplace_back(rng.uniform(0, 1), rng.uniform(0, 1), rng.uniform(0, 0.05));
  const PointList kept = thinned(points, 0.1);
  EXPECT_EQ(kept.size(), 100U);
  const PointList fine = thinned(points, 0.01);
  double mean_z = 0.0;
  for (const Vec3& p : fine) mean_z += p.z() / static_cast<double>(fine.size());
  EXPECT_NEAR(mean_z, 0.025, 1e-3);
  EXPECT_EQ(drawn(points, 50).size(), 50U);
  EXPECT_EQ(drawn(points, 50), drawn(points, 50));
}

}  // namespace
}  // namespace rali::eval
