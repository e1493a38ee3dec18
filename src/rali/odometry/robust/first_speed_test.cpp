#include "rali/odometry/robust/first_speed.hpp"

#include <cmath>
#include <span>
#include <vector>

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

// Measured in a hall (campaign, seed 898, v1, 11 scans), true speed 0.65 m/s: at 0.9 m/s a wall was
// mapped twice and fitted better, and gravity took the difference, 1.9 deg.
TEST(FirstSpeed, of_two_about_as_good_one_that_another_leads_to_is_preferred) {
  std::vector<TriedSpeed> tried = {{0.74, 0.649, -1.6225}, {0.4, 0.651, -1.6653},
                                   {0.8, 0.648, -1.5879},  {0.6, 0.649, -1.6183},
                                   {0.7, 0.649, -1.5731},  {0.9, 0.805, -1.5716}};
  EXPECT_EQ(tried[best_speed(tried, 0.2).value()].first_mps, 0.7);
  tried.back().value = -1.4;
  EXPECT_EQ(tried[best_speed(tried, 0.2).value()].first_mps, 0.9) << "much better";
  EXPECT_EQ(best_speed(std::span(tried).last(1), 0.2), 0U) << "the only one";
  EXPECT_FALSE(best_speed({}, 0.2).has_value());
}

}  // namespace
}  // namespace rali::odometry
