#include "rali/odometry/robust/first_speed.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace rali::odometry {
namespace {

// Measured in a yard (accuracy, seed 83, 26 scans): the true speed, and one that drifts upwards.
constexpr FirstSpeedFit kTrue{1.44, 0.02, 0.072, 0.008, 0.021};
constexpr FirstSpeedFit kDrifting{3.92, 2.54, 0.109, 0.010, 0.095};

TEST(FirstSpeed, score_matches_hand_computed_values) {
  // ln(0.5 + 3 * 0.1) - (2 + 1) / 10 - 0.15 ln(0.1)
  EXPECT_NEAR(value_of({2.0, 1.0, 0.5, 0.1, 0.1}), -0.22314 - 0.3 + 0.34539, 1e-4);
}

TEST(FirstSpeed, score_of_an_implausible_motion_is_lower_despite_more_wall_points) {
  EXPECT_GT(kDrifting.on_walls, kTrue.on_walls);
  EXPECT_GT(value_of(kTrue), value_of(kDrifting));
}

TEST(FirstSpeed, score_prefers_the_smaller_speed_sigma_at_equal_fit) {
  FirstSpeedFit known = kTrue;
  known.speed_sigma_mps *= 0.5;
  EXPECT_GT(value_of(known), value_of(kTrue));
  known.nis += 1.1;  // as much as 0.15 ln 2, and a little more
  EXPECT_LT(value_of(known), value_of(kTrue));
}

TEST(FirstSpeed, score_without_wall_points_is_low_but_finite) {
  const double none = value_of({0.0, 0.0, 0.0, 0.0, 0.05});
  EXPECT_TRUE(std::isfinite(none));
  EXPECT_LT(none, value_of(kDrifting));
}

}  // namespace
}  // namespace rali::odometry
