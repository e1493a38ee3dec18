#include "rali/odometry/robust/laser_errors.hpp"

#include <cmath>
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

/// 10000 points of each of four lasers on the floor, 2 to 12 m away.
LaserErrors measured(const double (&elevation_deg)[4], const double (&range_m)[4] = {}) {
  LaserErrors out;
  for (std::uint16_t laser = 0; laser < 4; ++laser) {
    for (int k = 0; k < 10000; ++k) {
      out.add(floor_point(laser, 2.0 + 0.001 * k, elevation_deg[laser] * kDegree, range_m[laser]));
    }
  }
  return out;
}

TEST(LaserErrors, have_the_prior_before_any_measurement) {
  const LaserCalibration none = LaserErrors().calibration(kPrior_rad);
  EXPECT_DOUBLE_EQ(none.elevation_sigma_rad, kPrior_rad);
  EXPECT_TRUE(none.errors.empty());
}

// By 10000 points of 2 cm, 8 m away, an elevation is known to 0.002 degrees, and to 0.02 with what
// planes have in common. These four scatter by 0.11 degrees, so 3 % of each is taken for noise:
// 0.02^2 / (0.11^2 + 0.02^2). Ranges scatter by 19 mm and are known to 5 mm: 6 %.
TEST(LaserErrors, are_found_for_each_laser) {
  const double elevation_deg[4] = {0.1, -0.1, 0.05, 0.15};
  const double range_m[4] = {0.02, -0.01, 0.0, 0.03};
  const LaserCalibration found = measured(elevation_deg, range_m).calibration(kPrior_rad);
  ASSERT_EQ(found.errors.size(), 4U);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_NEAR(found.errors[k].elevation_rad / kDegree, elevation_deg[k], 0.006) << k;
    EXPECT_NEAR(found.errors[k].range_m, range_m[k], 0.004) << k;
  }
  EXPECT_NEAR(found.elevation_sigma_rad / kDegree, 0.0197, 0.001);
}

TEST(LaserErrors, are_small_for_lasers_without_errors_however_large_the_prior) {
  const LaserErrors none = measured({0.0, 0.0, 0.0, 0.0});
  EXPECT_LT(none.calibration(kPrior_rad).elevation_sigma_rad, 0.02 * kDegree);
  EXPECT_LT(none.calibration(10.0 * kPrior_rad).elevation_sigma_rad, 0.02 * kDegree);
}

TEST(LaserErrors, of_range_are_hardly_taken_for_elevation) {
  const LaserCalibration far =
      measured({0.0, 0.0, 0.0, 0.0}, {0.05, 0.05, 0.05, 0.05}).calibration(kPrior_rad);
  EXPECT_LT(std::abs(far.errors[0].elevation_rad), 0.01 * kDegree);
  EXPECT_NEAR(far.errors[0].range_m, 0.05, 0.005);
}

// A wall does not show the elevation of a level laser, but its range.
TEST(LaserErrors, keep_the_prior_where_nothing_shows_an_elevation) {
  LaserErrors wall;
  for (int k = 0; k < 1000; ++k) wall.add({3, 0.01, 0.0, 1.0, kWeight});
  const LaserCalibration found = wall.calibration(kPrior_rad);
  EXPECT_DOUBLE_EQ(found.elevation_sigma_rad, kPrior_rad);
  EXPECT_DOUBLE_EQ(found.of(3).elevation_rad, 0.0);
  EXPECT_NEAR(found.of(3).range_m, 0.01, 0.002);
  EXPECT_DOUBLE_EQ(found.of(2).range_m, 0.0);
  EXPECT_DOUBLE_EQ(found.of(999).range_m, 0.0) << "a laser that was never seen";
}

// 10 m ahead and 1 m down, 0.1 degrees of elevation are 17.5 mm across the ray.
TEST(LaserErrors, are_subtracted_from_the_points_of_their_laser) {
  sensor::LidarScan scan;
  scan.has_rings = true;
  scan.push_back(6.0F, 8.0F, -1.0F, 0.0F, 0.0F, 1);
  scan.push_back(6.0F, 8.0F, -1.0F, 0.0F, 0.0F, 0);
  scan.push_back(6.0F, 8.0F, -1.0F, 0.0F, 0.0F, 2);
  scan.push_back(0.0F, 0.0F, 3.0F, 0.0F, 0.0F, 1);
  subtract_laser_errors({{LaserError{}, {0.1 * kDegree, 0.0}, {0.0, 0.1}}, 0.0}, scan);
  EXPECT_NEAR(scan.z_m[0], -1.01745, 1e-5);
  EXPECT_NEAR(std::hypot(scan.x_m[0], scan.y_m[0]), 10.0 - 0.001745, 1e-5);
  EXPECT_NEAR(scan.y_m[0] / scan.x_m[0], 8.0 / 6.0, 1e-6);
  EXPECT_FLOAT_EQ(scan.z_m[1], -1.0F);
  EXPECT_NEAR(scan.z_m[2], -1.0 + 0.1 / std::hypot(10.0, 1.0), 1e-6);
  EXPECT_NEAR(scan.x_m[2], 6.0 - 0.6 / std::hypot(10.0, 1.0), 1e-5);
  EXPECT_FLOAT_EQ(scan.z_m[3], 3.0F) << "straight up no elevation changes it";
}

}  // namespace
}  // namespace rali::odometry
