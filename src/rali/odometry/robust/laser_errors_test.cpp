#include "rali/odometry/robust/laser_errors.hpp"

#include <numbers>

#include <gtest/gtest.h>

namespace rali::odometry {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kPrior_rad = 0.1 * kDegree;
constexpr double kWeight = 2500.0;  // 2 cm

/// A point on the floor whose distance from it also depends on the range a little.
LaserResidual floor_point(std::uint16_t laser, double distance_m, double elevation_rad,
                          double range_m) {
  const double per_range = -0.5 / distance_m;
  return {laser, distance_m * elevation_rad + per_range * range_m, distance_m, per_range, kWeight};
}

/// 100 points of each of four lasers on the floor, 2 to 12 m away.
LaserErrors measured(const double (&elevation_deg)[4], double range_m = 0.0) {
  LaserErrors out;
  for (std::uint16_t laser = 0; laser < 4; ++laser) {
    for (int k = 0; k < 100; ++k) {
      out.add(floor_point(laser, 2.0 + 0.1 * k, elevation_deg[laser] * kDegree, range_m));
    }
  }
  return out;
}

TEST(LaserErrors, have_the_prior_before_any_measurement) {
  EXPECT_DOUBLE_EQ(LaserErrors().elevation_sigma_rad(kPrior_rad), kPrior_rad);
}

// The mean square of 0.1, -0.1, 0.05 and 0.15 degrees is 0.106 squared. An elevation is known to
// 0.015 degrees by 100 points of 2 cm, 8 m away, whose range is not known.
TEST(LaserErrors, are_the_root_of_their_mean_square) {
  const double sigma_deg =
      measured({0.1, -0.1, 0.05, 0.15}).elevation_sigma_rad(kPrior_rad) / kDegree;
  EXPECT_NEAR(sigma_deg, 0.106, 0.006);
}

TEST(LaserErrors, are_small_for_lasers_without_errors_however_large_the_prior) {
  const LaserErrors none = measured({0.0, 0.0, 0.0, 0.0});
  EXPECT_LT(none.elevation_sigma_rad(kPrior_rad), 0.03 * kDegree);
  EXPECT_LT(none.elevation_sigma_rad(10.0 * kPrior_rad), 0.03 * kDegree);
}

TEST(LaserErrors, of_range_are_not_taken_for_elevation) {
  const LaserErrors far = measured({0.0, 0.0, 0.0, 0.0}, 0.05);
  EXPECT_LT(far.elevation_sigma_rad(kPrior_rad), 0.03 * kDegree);
}

// A wall does not show the elevation of a level laser.
TEST(LaserErrors, keep_the_prior_where_nothing_shows_an_elevation) {
  LaserErrors wall;
  for (int k = 0; k < 1000; ++k) wall.add({3, 0.01, 0.0, 1.0, kWeight});
  EXPECT_DOUBLE_EQ(wall.elevation_sigma_rad(kPrior_rad), kPrior_rad);
}

}  // namespace
}  // namespace rali::odometry
