#include "rali/odometry/robust/range_noise.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::odometry {
namespace {

/// A square room of 8 m scanned by 16 rings, column by column.
sensor::LidarScan room(double sigma_m, bool rings = true) {
  sensor::LidarScan scan;
  scan.has_rings = rings;
  Rng rng(3, "room");
  for (int column = 0; column < 1800; ++column) {
    const double azimuth = column * 2.0 * M_PI / 1800.0;
    for (int ring = 0; ring < 16; ++ring) {
      const double elevation = (2.0 * ring - 15.0) * M_PI / 180.0;
      const double wall = 4.0 / std::max(std::abs(std::cos(azimuth)), std::abs(std::sin(azimuth)));
      const double range = wall / std::cos(elevation) + sigma_m * rng.normal();
      const double flat = range * std::cos(elevation);
      scan.push_back(static_cast<float>(flat * std::cos(azimuth)),
                     static_cast<float>(flat * std::sin(azimuth)),
                     static_cast<float>(range * std::sin(elevation)), 0.0F, 0.0F,
                     static_cast<std::uint16_t>(ring));
    }
  }
  return scan;
}

TEST(RangeNoise, is_estimated_within_10_percent_independent_of_wall_shape) {
  for (const double sigma_m : {0.003, 0.01, 0.02, 0.05}) {
    const auto measured = measure_range_noise(room(sigma_m));
    ASSERT_TRUE(measured);
    EXPECT_NEAR(*measured, sigma_m, 0.1 * sigma_m);
  }
  EXPECT_LT(*measure_range_noise(room(0.0)), 1e-3);
}

TEST(RangeNoise, is_not_estimated_without_rings_or_points) {
  EXPECT_FALSE(measure_range_noise(room(0.02, false)));
  EXPECT_FALSE(measure_range_noise(sensor::LidarScan{}));
}

}  // namespace
}  // namespace rali::odometry
