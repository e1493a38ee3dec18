#include "rali/odometry/robust/range_picture.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::odometry {
namespace {

/// A LiDAR of 16 rings in a tunnel 4 m wide without floor and ceiling, with a post of 0.3 m beside
/// the path; seen from `x_m`, where the post stands at 10 m.
sensor::LidarScan tunnel(double x_m, std::uint64_t seed, bool with_post, bool with_rings = true) {
  Rng rng(seed, "tunnel");
  sensor::LidarScan scan;
  scan.has_rings = with_rings;
  for (int column = 0; column < 900; ++column) {
    // The sensor does not fire at the same angles in each turn.
    const double turn = (column + rng.uniform()) * 2.0 * M_PI / 900.0;
    const double side_m = 2.0 / std::max(0.02, std::abs(std::sin(turn)));
    const double post_m = 10.0 - x_m;
    const bool hits =
        with_post && std::cos(turn) > 0.0 && std::abs(post_m * std::tan(turn) - 1.0) < 0.15;
    for (int ring = 0; ring < 16; ++ring) {
      const double up = (2.0 * ring - 15.0) * M_PI / 180.0;
      const double across_m = hits ? post_m / std::cos(turn) : side_m;
      const double noise = 1.0 + 0.02 * rng.normal() / across_m;
      scan.push_back(static_cast<float>(noise * across_m * std::cos(turn)),
                     static_cast<float>(noise * across_m * std::sin(turn)),
                     static_cast<float>(noise * across_m * std::tan(up)), 0.0F, 0.0F,
                     with_rings ? static_cast<std::uint16_t>(ring) : std::uint16_t{0});
    }
  }
  return scan;
}

TEST(RangePicture, stays_the_same_at_standstill_despite_noise_and_other_firing_angles) {
  for (const bool with_rings : {true, false}) {
    EXPECT_FALSE(view_has_changed(tunnel(0.0, 1, true, with_rings),
                                  tunnel(0.0, 2, true, with_rings),
                                  tunnel(0.0, 3, true, with_rings)));
  }
}

TEST(RangePicture, changes_when_the_vehicle_moves_past_a_single_post) {
  for (const bool with_rings : {true, false}) {
    EXPECT_TRUE(view_has_changed(tunnel(0.0, 1, true, with_rings),
                                 tunnel(0.04, 2, true, with_rings),
                                 tunnel(0.8, 3, true, with_rings)));
  }
}

TEST(RangePicture, shows_no_motion_along_a_bare_tunnel) {
  EXPECT_FALSE(
      view_has_changed(tunnel(0.0, 1, false), tunnel(0.04, 2, false), tunnel(0.8, 3, false)));
}

TEST(RangePicture, compares_nothing_with_an_empty_scan) {
  const sensor::LidarScan scan = tunnel(0.0, 1, true);
  EXPECT_EQ(RangePicture(sensor::LidarScan{}).changed(scan), 0.0);
  EXPECT_EQ(RangePicture(scan).changed(sensor::LidarScan{}), 0.0);
}

}  // namespace
}  // namespace rali::odometry
