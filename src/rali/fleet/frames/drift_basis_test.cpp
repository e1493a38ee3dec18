#include "rali/fleet/frames/drift_basis.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "rali/fleet/frames/yaw_pose.hpp"

namespace rali::fleet {
namespace {

using geometry::Mat3;
using geometry::Vec3;

Mat3 covariance(const Eigen::Matrix3Xd& D) { return D * D.transpose(); }

/// Errors of the position of each sample.
std::vector<Eigen::Matrix3Xd> drift_basis(const std::vector<PathSample>& path,
                                          const DriftSettings& settings) {
  const DriftBasis basis(path, settings);
  std::vector<Eigen::Matrix3Xd> out;
  for (const PathSample& s : path) out.emplace_back(basis.at(s.t, s.p_m).bottomRows<3>());
  return out;
}

std::vector<PathSample> straight(double growth_m2) {
  std::vector<PathSample> path;
  for (int k = 0; k <= 100; ++k) {
    PathSample s;
    s.t = Time::from_s(k);
    s.p_m = Vec3(0.2 * k, 0.0, 0.0);
    s.covariance_m2(0, 0) = growth_m2 * k / 100.0;
    path.push_back(s);
  }
  return path;
}

// 20 m: scale 0.5 % is 0.1 m along; a random walk of q per root metre is q sqrt(20^3 / 3) across;
// vertically the tilt acts.
TEST(DriftBasis, of_a_straight_path_has_the_variances_of_its_random_walk) {
  DriftSettings settings;
  settings.segments = 32;
  const auto D = drift_basis(straight(0.0), settings);
  ASSERT_EQ(D.size(), 101u);
  EXPECT_NEAR(covariance(D.front()).norm(), 0.0, 1e-12);
  const Mat3 C = covariance(D.back());
  const double q = 0.05 * kDegree;
  EXPECT_NEAR(C(0, 0), 0.01, 1e-9);
  EXPECT_NEAR(C(1, 1), q * q * 20.0 * 20.0 * 20.0 / 3.0, 1e-5);
  EXPECT_NEAR(C(2, 2), 0.25 * kDegree * kDegree * 400.0, 1e-9);
}

TEST(DriftBasis, reproduces_the_growth_of_a_reported_covariance) {
  DriftSettings settings;
  settings.scale = settings.yaw_deg_per_sqrt_m = settings.tilt_deg = 0.0;
  const auto D = drift_basis(straight(4.0), settings);
  EXPECT_NEAR(covariance(D.back())(0, 0), 4.0, 1e-9);
  EXPECT_NEAR(covariance(D[50])(0, 0), 2.0, 1e-9);
  // Errors at two places share all earlier ones: correlated as a random walk.
  EXPECT_NEAR((D[50] * D.back().transpose())(0, 0), 2.0, 1e-9);
}

// Half a metre in 2 m: six pieces of 3.3 m would leave 0.24 of the 0.4 m^2, and ranges would
// contradict the true frames.
TEST(DriftBasis, of_a_large_growth_bends_within_metres) {
  DriftSettings settings;
  settings.scale = settings.yaw_deg_per_sqrt_m = settings.tilt_deg = 0.0;
  const auto D = drift_basis(straight(4.0), settings);
  EXPECT_NEAR(covariance(D[55] - D[45])(0, 0), 0.4, 0.1);
  EXPECT_EQ(drift_basis(straight(0.1), settings).front().cols(), settings.segments);
}

TEST(DriftBasis, has_no_columns_at_standstill_or_without_a_path) {
  EXPECT_TRUE(drift_basis({}, {}).empty());
  const std::vector<PathSample> stands(5);
  const auto D = drift_basis(stands, {});
  ASSERT_EQ(D.size(), 5u);
  EXPECT_EQ(D.front().cols(), 0);
}

// The order in which pairs add samples of a path must have no effect.
TEST(DriftBasis, does_not_depend_on_the_order_of_the_samples) {
  std::vector<PathSample> path = straight(1.0);
  const auto forward = drift_basis(path, {});
  std::reverse(path.begin(), path.end());
  const auto backward = drift_basis(path, {});
  for (std::size_t k = 0; k < path.size(); ++k) {
    EXPECT_EQ(forward[k], backward[path.size() - 1 - k]);
  }
}

}  // namespace
}  // namespace rali::fleet
