#include "rali/ranging/range_gate.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace rali::ranging {
namespace {

const GateSettings kSettings;

// The numbers printed in algorithms 4.3, step 5.
TEST(RangeGate, one_sided_weights_match_hand_computed_values) {
  EXPECT_NEAR(one_sided_weight(0.95, kSettings), 0.51, 0.005);
  EXPECT_NEAR(one_sided_weight(2.5, kSettings), 0.07, 0.005);
  EXPECT_NEAR(one_sided_weight(3.8, kSettings), 0.02, 0.005);
  EXPECT_NEAR(one_sided_weight(-0.95, kSettings), 0.87, 0.005);
  EXPECT_NEAR(one_sided_weight(-3.8, kSettings), 0.30, 0.005);
  EXPECT_EQ(one_sided_weight(0.0, kSettings), 1.0);
}

// Test T9 of the design, its last part: S = 0.04 + 0.01 m^2 along the line of sight.
TEST(RangeGate, accepts_the_range_of_the_worked_example) {
  const double S = 0.039900 + 0.000025 + 0.01;
  const GateDecision out = gate(0.475016, S, 0.1, true, kSettings);
  EXPECT_NEAR(out.d * out.d, 4.52, 0.005);
  EXPECT_TRUE(out.inside);
}

TEST(RangeGate, widens_with_the_innovation_covariance) {
  // In a tunnel, sd 1 m along the line, sigma 0.1: the gate is at 3.29 x 1.005 = 3.307 m.
  EXPECT_TRUE(gate(3.30, 1.01, 0.1, true, kSettings).inside);
  EXPECT_FALSE(gate(3.32, 1.01, 0.1, true, kSettings).inside);
  // In a room, sd 2 cm: 0.336 m.
  EXPECT_TRUE(gate(-0.33, 0.0104, 0.1, true, kSettings).inside);
  EXPECT_FALSE(gate(-0.34, 0.0104, 0.1, true, kSettings).inside);
}

TEST(RangeGate, a_line_of_sight_range_near_its_prediction_has_full_weight) {
  for (const double nu : {-0.19, -0.05, 0.0, 0.1, 0.19}) {
    const GateDecision out = gate(nu, 0.01, 0.1, true, kSettings);
    EXPECT_EQ(out.weight, 1.0) << nu;
    EXPECT_NEAR(out.R_m2, 0.01, 1e-15);
  }
}

TEST(RangeGate, a_line_of_sight_range_far_off_is_weighted_one_sided) {
  const GateDecision longer = gate(0.25, 0.01, 0.1, true, kSettings);
  const GateDecision shorter = gate(-0.25, 0.01, 0.1, true, kSettings);
  EXPECT_NEAR(longer.R_m2, 0.01 / 0.0701, 1e-4);
  EXPECT_NEAR(shorter.R_m2, 0.02, 1e-12);  // (1 + 1)^-1
}

TEST(RangeGate, an_nlos_range_is_always_weighted_one_sided) {
  EXPECT_NEAR(gate(0.095, 0.01, 0.1, false, kSettings).weight, 0.51, 0.005);
  EXPECT_NEAR(gate(-0.095, 0.01, 0.1, false, kSettings).weight, 0.87, 0.005);
}

TEST(RangeGate, huber_weights_apply_below_the_one_sided_threshold) {
  GateSettings s;
  s.one_sided_above = 3.0;
  EXPECT_NEAR(gate(0.25, 0.01, 0.1, true, s).weight, 0.8, 1e-12);
  EXPECT_NEAR(gate(-0.25, 0.01, 0.1, true, s).weight, 0.8, 1e-12);
}

TEST(RangeGate, rejects_nan_innovations_and_invalid_variances) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(gate(nan, 0.01, 0.1, true, kSettings).inside);
  EXPECT_FALSE(gate(0.0, nan, 0.1, true, kSettings).inside);
  EXPECT_FALSE(gate(0.0, 0.0, 0.1, true, kSettings).inside);
  EXPECT_FALSE(gate(0.0, -1.0, 0.1, true, kSettings).inside);
  EXPECT_FALSE(gate(0.0, 0.01, nan, true, kSettings).inside);
  EXPECT_FALSE(gate(0.0, std::numeric_limits<double>::infinity(), 0.1, true, kSettings).inside);
}

}  // namespace
}  // namespace rali::ranging
