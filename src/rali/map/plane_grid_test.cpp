#include "rali/map/plane_grid.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::map {
namespace {

/// A wall of 4 x 2 m across x with Gaussian thickness, optionally doubled.
MapCloud wall(double sigma_m, double second_sheet_m = 0.0) {
  MapCloud cloud;
  Rng rng(7, "wall");
  for (int i = 0; i < 20000; ++i) {
    const double sheet = i % 2 == 0 ? 0.0 : second_sheet_m;
    cloud.x_m.push_back(static_cast<float>(0.2 + sheet + sigma_m * rng.normal()));
    cloud.y_m.push_back(static_cast<float>(rng.uniform(0, 4)));
    cloud.z_m.push_back(static_cast<float>(rng.uniform(0, 2)));
  }
  return cloud;
}

TEST(WallThickness, a_wall_with_1_cm_of_noise_is_1_cm_thick) {
  const Thickness t = wall_thickness(wall(0.01));
  EXPECT_EQ(t.planes, 50U);
  EXPECT_NEAR(t.median_m, 0.01, 0.0005);
}

TEST(WallThickness, of_two_sheets_6_cm_apart_is_3_2_cm) {
  // sqrt(0.01^2 + 0.03^2)
  EXPECT_NEAR(wall_thickness(wall(0.01, 0.06)).median_m, 0.0316, 0.001);
}

TEST(PlaneGrid, gives_the_distance_to_a_plane_up_to_two_cubes_away) {
  PlaneGrid grid;  // a floor at z = 0.1 m, 0.4 m square, points 4 cm apart
  for (int i = 0; i < 100; ++i) grid.add({0.02 + 0.04 * (i % 10), 0.02 + 0.04 * (i / 10), 0.1});
  EXPECT_NEAR(grid.distance_to_planes_m({0.6, 0.2, 0.13}), 0.03, 1e-9);
  EXPECT_NEAR(grid.distance_to_planes_m({0.2, -0.2, 0.5}), 0.4, 1e-9);
  EXPECT_NEAR(grid.distance_to_planes_m({1.1, 0.2, 0.13}), 0.03, 1e-9);
  EXPECT_TRUE(std::isinf(grid.distance_to_planes_m({1.3, 0.2, 0.1})));
}

TEST(WallThickness, counts_no_planes_in_empty_or_non_planar_clouds) {
  EXPECT_EQ(wall_thickness({}).planes, 0U);
  MapCloud ball;
  Rng rng(1, "ball");
  for (int i = 0; i < 1000; ++i) {
    for (auto* v : {&ball.x_m, &ball.y_m, &ball.z_m}) {
      v->push_back(static_cast<float>(rng.uniform(0.0, 0.4)));
    }
  }
  EXPECT_EQ(wall_thickness(ball).planes, 0U);
}

}  // namespace
}  // namespace rali::map
