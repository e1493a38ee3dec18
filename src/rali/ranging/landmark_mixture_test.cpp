#include "rali/ranging/landmark_mixture.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace rali::ranging {
namespace {

using geometry::Vec3;
using Mixture = LandmarkMixture;

/// Sigmas: own position along x 0.1 m and 0.05 m/s, the peer's along x 0.2 m, across `across_m`,
/// stamps 1 ms.
Mixture::Matrix known_to(double across_m) {
  Mixture::Matrix P = Mixture::Matrix::Zero(Mixture::kBias, Mixture::kBias);
  P.diagonal() << 0.01, 0.0025, 0.04, across_m * across_m, 1e-6;
  return P;
}

/// The same, and one more quantity without correlation.
Eigen::MatrixXd and_bias(const Mixture::Matrix& P, double variance_m2 = 0.01) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(P.rows() + 1, P.cols() + 1);
  out.topLeftCorner(P.rows(), P.cols()) = P;
  out(P.rows(), P.cols()) = variance_m2;
  return out;
}

Mixture mixture(double across_m, double bias_variance_m2 = 0.01) {
  const Mixture::Matrix P = known_to(across_m);
  Mixture m(MixtureSettings{}, Vec3::UnitX(), Vec3::UnitY(), P);
  EXPECT_EQ(m.add_bias(and_bias(P, bias_variance_m2)), Mixture::kBias);
  return m;
}

MixtureSight from(double x_m) {
  MixtureSight s;
  s.p_odom_antenna_m = Vec3(x_m, 0.0, 0.0);
  s.v_odom_antenna_mps = Vec3::UnitX();
  return s;
}

TEST(LandmarkMixture, starts_with_the_mean_and_covariance_of_its_gaussian) {
  const Mixture m = mixture(3.0);
  EXPECT_GT(m.slices(), 20);
  EXPECT_LT(m.mean().norm(), 1e-9);
  EXPECT_NEAR(m.covariance()(Mixture::kAcross, Mixture::kAcross), 9.0, 0.3);
  EXPECT_NEAR(m.covariance()(Mixture::kAlong, Mixture::kAlong), 0.01, 1e-9);
}

TEST(LandmarkMixture, preserves_correlations_with_the_lateral_position) {
  Mixture::Matrix P = known_to(2.0);
  P(Mixture::kAlong, Mixture::kAcross) = P(Mixture::kAcross, Mixture::kAlong) = 0.1;
  const Mixture m(MixtureSettings{}, Vec3::UnitX(), Vec3::UnitY(), P);
  EXPECT_NEAR(m.covariance()(Mixture::kAlong, Mixture::kAcross), 0.1, 0.005);
  EXPECT_NEAR(m.covariance()(Mixture::kAlong, Mixture::kAlong), 0.01, 2e-4);
}

// A landmark initialised by this very pair is correlated with its bias: that must be kept.
TEST(LandmarkMixture, adding_a_bias_preserves_its_correlations) {
  Mixture::Matrix P = and_bias(known_to(2.0));
  P(Mixture::kPlace, Mixture::kBias) = P(Mixture::kBias, Mixture::kPlace) = -0.018;
  P(Mixture::kAcross, Mixture::kBias) = P(Mixture::kBias, Mixture::kAcross) = 0.05;
  Mixture m(MixtureSettings{}, Vec3::UnitX(), Vec3::UnitY(), known_to(2.0));
  EXPECT_EQ(m.add_bias(P), Mixture::kBias);
  const Mixture::Matrix now = m.covariance();
  EXPECT_NEAR(now(Mixture::kPlace, Mixture::kBias), -0.018, 1e-9);
  EXPECT_NEAR(now(Mixture::kAcross, Mixture::kBias), 0.05, 0.003);
  EXPECT_NEAR(now(Mixture::kBias, Mixture::kBias), 0.01, 1e-4);
}

TEST(LandmarkMixture, equals_a_kalman_filter_at_long_range) {
  Mixture m = mixture(0.1);
  // S: 0.01 + 0.04 + 0.01 + 1e-6 + R 0.01; the own position follows by 0.01 / S of the residual.
  const MixtureSight sight = from(-50.0);
  EXPECT_NEAR(m.predict(sight, Mixture::kBias).predicted_m, 50.0, 1e-3);
  EXPECT_NEAR(m.predict(sight, Mixture::kBias).variance_m2, 0.060001, 1e-5);
  m.update(sight, Mixture::kBias, 0.07, 0.01, false);
  EXPECT_NEAR(m.mean()[Mixture::kAlong], -0.07 * 0.01 / 0.070001, 1e-4);
  EXPECT_NEAR(m.mean()[Mixture::kPlace], 0.07 * 0.04 / 0.070001, 1e-4);
  EXPECT_NEAR(m.covariance()(Mixture::kAlong, Mixture::kAlong), 0.01 - 1e-4 / 0.070001, 1e-6);
  EXPECT_NEAR(m.covariance()(Mixture::kAcross, Mixture::kAcross), 0.01, 1e-9);
}

TEST(LandmarkMixture, one_range_corrects_8_m_of_drift_along_the_passage) {
  // Estimated 20 m before the peer, with sigma 8 m; in truth 12 m. The lateral offset is 3 m: from
  // -20 m the distance changes by 0.989 m per metre, from -12 m by 0.970.
  Mixture::Matrix P = known_to(0.01);
  P.diagonal() << 64.0, 0.0025, 1e-6, 1e-4, 1e-6;
  Mixture m(MixtureSettings{}, Vec3::UnitX(), Vec3::UnitY(), P);
  ASSERT_EQ(m.add_bias(and_bias(P)), Mixture::kBias);
  MixtureSight sight = from(-20.0);
  sight.p_odom_peer_m = Vec3(0.0, 3.0, 0.0);
  const double predicted_m = m.predict(sight, Mixture::kBias).predicted_m;
  m.update(sight, Mixture::kBias, std::hypot(12.0, 3.0) - predicted_m, 1e-4, false);
  EXPECT_NEAR(m.mean()[Mixture::kAlong], 8.0, 0.01);
  EXPECT_NEAR(m.mean()[Mixture::kBias], 0.0, 0.005);
  // The uncertainty left by the bias, 0.1 m, and by the range, 0.01 m, over 0.970.
  EXPECT_NEAR(std::sqrt(m.covariance()(Mixture::kAlong, Mixture::kAlong)), 0.1036, 0.002);
}

TEST(LandmarkMixture, represents_both_sides_after_passing_and_selects_one) {
  Mixture m = mixture(3.0);
  for (double x_m = -10.0; x_m < 8.0; x_m += 0.1) {
    const MixtureSight sight = from(x_m);
    const double predicted_m = m.predict(sight, Mixture::kBias).predicted_m;
    m.update(sight, Mixture::kBias, std::hypot(x_m, 1.5) - predicted_m, 0.04, true);
  }
  // On a straight path left and right are equal: the mean is on the path, the covariance has both.
  EXPECT_NEAR(m.mean()[Mixture::kAcross], 0.0, 0.1);
  EXPECT_NEAR(m.covariance()(Mixture::kAcross, Mixture::kAcross), 2.25, 0.3);
  EXPECT_NEAR(m.mean()[Mixture::kAlong], 0.0, 0.05);
  m.take_side();
  EXPECT_NEAR(std::abs(m.mean()[Mixture::kAcross]), 1.5, 0.15);
  EXPECT_NEAR(m.covariance()(Mixture::kAcross, Mixture::kAcross), 4.5, 0.6);  // (2 * 1.5)^2 / 2
  m.recentre();
  EXPECT_LT(m.mean().norm(), 1e-9);
}

TEST(LandmarkMixture, follows_filter_propagation_and_zero_velocity_updates) {
  Mixture m = mixture(1.0);
  Mixture::Matrix now = m.covariance();
  now(Mixture::kAlong, Mixture::kAlong) += 0.0025;  // 1 s at 0.05 m/s
  now(Mixture::kAlong, Mixture::kSpeed) = now(Mixture::kSpeed, Mixture::kAlong) = 0.0025;
  m.move(1.0, now);
  EXPECT_NEAR(m.covariance()(Mixture::kAlong, Mixture::kAlong), 0.0125, 1e-6);
  EXPECT_NEAR(m.covariance()(Mixture::kSpeed, Mixture::kSpeed), 0.0025, 1e-6);
  now(Mixture::kSpeed, Mixture::kSpeed) = 1e-6;  // standstill
  m.move(0.0, now);
  EXPECT_NEAR(m.covariance()(Mixture::kSpeed, Mixture::kSpeed), 1e-6, 1e-8);
}

TEST(LandmarkMixture, applies_the_lateral_constraint_of_a_passage_once) {
  Mixture m = mixture(5.0);
  m.stands_within(from(-20.0), 0.0, 1.0);
  // N(0, 5^2) times N(0, 1).
  EXPECT_NEAR(m.covariance()(Mixture::kAcross, Mixture::kAcross), 25.0 / 26.0, 0.2);
  m.stands_within(from(-20.0), 0.0, 1.0);  // repeated, it counts once
  EXPECT_NEAR(m.covariance()(Mixture::kAcross, Mixture::kAcross), 25.0 / 26.0, 0.2);
}

TEST(LandmarkMixture, limits_the_number_of_pair_biases) {
  Mixture m = mixture(1.0);
  for (int k = Mixture::kBias + 1; k < Mixture::kMax; ++k) {
    EXPECT_EQ(m.add_bias(and_bias(m.covariance())), k);
  }
  EXPECT_EQ(m.add_bias(and_bias(m.covariance())), -1);
  EXPECT_EQ(m.size(), Mixture::kMax);
}

}  // namespace
}  // namespace rali::ranging
