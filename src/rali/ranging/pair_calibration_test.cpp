#include "rali/ranging/pair_calibration.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::ranging {
namespace {

using geometry::Mat3;
using geometry::Vec3;

/// The peer started at (10, 0); its heading is certain.
PairPrior prior() {
  PairPrior p;
  p.origin_m = {10.0, 0.0, 0.0};
  p.sigma_rad = 0.0;
  return p;
}

// Position and constant have the same sigma as the range, and the range is 0.3 m too long: each
// takes a third of it.
TEST(PairCalibration, distributes_a_residual_over_position_bias_and_noise_by_variance) {
  PairCalibration c(prior());
  c.start_stay({10.0, 0.0, 0.0}, Mat3::Zero());
  EXPECT_TRUE(c.add(Vec3::Zero(), 10.3));
  EXPECT_NEAR(c.constant_m(), 0.1, 1e-5);
  EXPECT_NEAR(c.place_m().x(), 10.1, 1e-5);
  // 0.01 + 0.01 - 0.02^2 / 0.03
  EXPECT_NEAR(c.variance_m2(Vec3::Zero()), 0.00667, 1e-4);
}

// From both sides 10.3 and 9.9 m: with d and b for position and constant less the prior's,
// 3 d = 0.4 and 3 b = 0.2.
TEST(PairCalibration, separates_position_and_bias_by_ranges_from_both_sides) {
  PairCalibration c(prior());
  c.start_stay({10.0, 0.0, 0.0}, Mat3::Zero());
  EXPECT_TRUE(c.add(Vec3::Zero(), 10.3));
  EXPECT_TRUE(c.add({20.0, 0.0, 0.0}, 9.9));
  EXPECT_NEAR(c.place_m().x(), 10.0 + 0.4 / 3.0, 1e-5);
  EXPECT_NEAR(c.constant_m(), 0.2 / 3.0, 1e-5);
}

TEST(PairCalibration, uses_one_range_per_metre_travelled) {
  PairCalibration c(prior());
  c.start_stay({10.0, 0.0, 0.0}, Mat3::Zero());
  EXPECT_TRUE(c.add(Vec3::Zero(), 10.3));
  EXPECT_FALSE(c.add({0.9, 0.0, 0.0}, 9.4));
  EXPECT_TRUE(c.add({1.1, 0.0, 0.0}, 9.2));
}

TEST(PairCalibration, keeps_the_bias_but_not_the_position_for_the_next_stop) {
  PairCalibration c(prior());
  c.start_stay({10.0, 0.0, 0.0}, Mat3::Identity());
  for (int k = 0; k < 30; ++k) {
    EXPECT_TRUE(c.add({1.0 * k - 5.0, 2.0, 0.0}, std::hypot(15.0 - k, 2.0) + 0.25));
  }
  const double constant_m = c.constant_m();
  EXPECT_NEAR(constant_m, 0.25, 0.05);
  c.end_stay();
  EXPECT_FALSE(c.in_stay());
  EXPECT_FALSE(c.add(Vec3::Zero(), 1.0));
  c.start_stay({40.0, 0.0, 0.0}, Mat3::Identity());
  EXPECT_NEAR(c.constant_m(), constant_m, 1e-12);
  // One metre of drift of the paths, which the first stay did not constrain.
  EXPECT_GT(c.variance_m2(Vec3::Zero()), 1.0);
}

// The peer reports 20 m, and its heading was measured 0.1 rad wrong: its position is 2 m off to the
// side. The next position is right before a range comes.
TEST(PairCalibration, estimates_the_heading_of_the_peer_frame_for_the_next_stop) {
  PairPrior p = prior();
  p.origin_m = Vec3::Zero();
  p.sigma_m = 0.01;
  p.sigma_rad = 0.05;
  PairCalibration c(p);
  const double yaw = 0.1;
  const Vec3 place(20.0 * std::cos(yaw), 20.0 * std::sin(yaw), 0.0);
  c.start_stay({20.0, 0.0, 0.0}, Mat3::Zero());
  for (int k = 0; k < 20; ++k) {
    const Vec3 from(1.0 * k, -1.0, 0.0);
    EXPECT_TRUE(c.add(from, (place - from).norm()));
  }
  EXPECT_NEAR(c.place_m().y(), place.y(), 0.15);
  c.start_stay({40.0, 0.0, 0.0}, Mat3::Zero());
  EXPECT_NEAR(c.place_m().y(), 40.0 * std::sin(yaw), 0.3);
}

TEST(PairCalibration, an_obstructed_range_changes_the_bias_by_under_6_cm) {
  PairCalibration c(prior());
  c.start_stay({10.0, 0.0, 0.0}, Mat3::Zero());
  for (int k = 0; k < 5; ++k) EXPECT_TRUE(c.add({2.0 * k, 0.0, 0.0}, 10.0 - 2.0 * k + 0.1));
  const double before_m = c.constant_m();
  EXPECT_TRUE(c.add({-2.0, 0.0, 0.0}, 15.0));
  EXPECT_LT(std::abs(c.constant_m() - before_m), 0.06);
}

TEST(PairCalibration, refuses_nan_positions_and_ranges) {
  PairCalibration c(prior());
  c.start_stay({10.0, 0.0, 0.0}, Mat3::Zero());
  EXPECT_FALSE(c.add({std::nan(""), 0.0, 0.0}, 10.0));
  EXPECT_FALSE(c.add(Vec3::Zero(), std::nan("")));
  EXPECT_TRUE(c.place_m().allFinite());
}

// Draws by its own assumptions: the squared error of distance plus constant fits its covariance.
TEST(PairCalibration, normalised_squared_error_has_a_mean_of_one) {
  Rng rng(7, "pair calibration");
  double squares = 0.0;
  constexpr int kRuns = 300;
  for (int run = 0; run < kRuns; ++run) {
    PairPrior p = prior();
    p.origin_m = Vec3::Zero();
    p.sigma_rad = 0.03;
    PairCalibration c(p);
    const double yaw = p.sigma_rad * rng.normal();
    const Vec3 shift(p.sigma_m * rng.normal(), p.sigma_m * rng.normal(), 0.0);
    const double constant_m = p.constant_sigma_m * rng.normal();
    constexpr double kDrift = 0.1;
    const Vec3 drift(kDrift * rng.normal(), kDrift * rng.normal(), 0.0);
    c.start_stay({12.0, 1.0, 0.0}, kDrift * kDrift * Mat3::Identity());
    const Vec3 arm(12.0 * std::cos(yaw) - std::sin(yaw), 12.0 * std::sin(yaw) + std::cos(yaw), 0.0);
    const Vec3 place = arm + shift + drift;
    for (int k = 0; k < 8; ++k) {
      const Vec3 from(1.2 * k, 0.0, 0.0);
      c.add(from, (place - from).norm() + constant_m + p.range_sigma_m * rng.normal());
    }
    const Vec3 at(11.0, 0.0, 0.0);
    const double error =
        (place - at).norm() + constant_m - (c.place_m() - at).norm() - c.constant_m();
    squares += error * error / c.variance_m2(at);
  }
  EXPECT_NEAR(squares / kRuns, 1.0, 0.3);
}

}  // namespace
}  // namespace rali::ranging
