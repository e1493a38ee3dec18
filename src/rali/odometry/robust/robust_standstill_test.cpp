#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "rali/odometry/robust/driven_for_test.hpp"

// Ranges that arrive during a scan, or at standstill.

namespace rali::odometry {
namespace {

using geometry::Vec3;

constexpr double kScan_s = TestRoom::kScan_s;

/// A measurement of the position along x.
AugmentedMeasurement along_x(const AugmentedFilter& filter, double residual_m) {
  AugmentedMeasurement m;
  m.d_pose[3] = 1.0;
  m.d_augmented = AugmentedStates::Vector::Zero(filter.augmented().size());
  m.residual = residual_m;
  return m;
}

/// The cloud of the next scan, with the pose shifted by about this much in the middle of it.
KeyframeCloud cloud_with_a_range(double shift_m) {
  OdometrySettings settings;
  settings.robust.keyframe.distance_m = 0.01;
  settings.robust.keyframe.voxel_m = 0.0;  // all points, in their order
  Driven driven(tunnel(), 25, true, settings);
  driven.imu_until(kScan_s * (driven.scans + 0.5));
  const Time middle = driven.t_end + Duration::from_s(0.5 * kScan_s);
  EXPECT_TRUE(driven.filter->advance_to(middle));
  if (shift_m != 0.0) {
    // As uncertain as after a long degenerate stretch.
    for (int k = 0; k < 20; ++k) driven.filter->widen(4.0);
    const Vec3 moved = driven.filter->apply(along_x(*driven.filter, shift_m), 1e-4);
    EXPECT_NEAR(moved.x(), shift_m, 0.1 * shift_m);
  }
  const ScanResult result = driven.scan();
  EXPECT_NE(result.keyframe, nullptr);
  return result.keyframe ? result.keyframe->cloud : KeyframeCloud{};
}

TEST(RangeWithinScan, moves_all_poses_of_the_scan_together) {
  const KeyframeCloud still = cloud_with_a_range(0.0);
  const KeyframeCloud moved = cloud_with_a_range(2.0);
  ASSERT_EQ(still.size(), moved.size());
  ASSERT_GT(still.size(), 500U);
  // Points at the start of the scan, against those at its end: were only the last pose moved, they
  // would lie 2 m apart. The speed correction by the range bends them by centimetres.
  float max_m = 0.0F;
  for (std::size_t i = 0; i < still.size(); ++i) {
    max_m = std::max(max_m, std::abs(still.x_m[i] - moved.x_m[i]));
  }
  EXPECT_LT(max_m, 0.3F);
}

/// Smallest eigenvalue of the joint covariance in units of its sigmas; at least 0 if it is valid.
double min_eigenvalue(const Driven& driven) {
  const Eigen::MatrixXd P = driven.filter->covariance(unit_rows(*driven.filter));
  const Eigen::VectorXd scale = P.diagonal().cwiseMax(1e-18).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * P * scale.asDiagonal();
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scaled).eigenvalues().minCoeff();
}

/// Regression of an augmented state on the position along x.
double gain_on_x(const Driven& driven) {
  const Eigen::MatrixXd P = driven.filter->covariance(unit_rows(*driven.filter));
  return P(DenseAugmentedFilter::kOwn, 3) / P(3, 3);
}

TEST(RangeWhileHeld, keeps_the_covariance_positive_semidefinite_when_standstill_ends) {
  TestRoom room = small_room();
  room.rest_s = 4.0;
  Driven driven(room, 38, true);
  ASSERT_TRUE(driven.now().at_rest);
  // A landmark with the error of the pose from which it was initialised.
  AugmentedStates::Vector mean(1);
  mean[0] = 7.0;
  AugmentedStates::Matrix own(1, 1);
  own(0, 0) = 1e-8;
  ASSERT_EQ(driven.filter->add_states(mean, own, {along_x(*driven.filter, 0.0)}), 0);
  EXPECT_GE(min_eigenvalue(driven), -1e-9);
  driven.scan();
  // Another estimate of the pose is a metre less certain, and shifted; the landmark follows.
  AugmentedStates::Matrix wide(1, 1);
  wide(0, 0) = 1.0;
  AugmentedStates::Vector shift(1);
  shift[0] = 0.2;
  ASSERT_TRUE(driven.now().at_rest);
  driven.filter->replace({along_x(*driven.filter, 0.0)}, shift, wide);
  const double gain = gain_on_x(driven);
  EXPECT_NEAR(gain, 1.0, 1e-3);
  EXPECT_GE(min_eigenvalue(driven), -1e-9);
  const double apart_m = driven.filter->augmented().mean[0] - driven.now().T_odom_body.p.x();
  while (driven.now().at_rest && driven.scans < 50) driven.scan();
  ASSERT_FALSE(driven.now().at_rest);
  EXPECT_GE(min_eigenvalue(driven), -1e-9);
  const double off_m =
      driven.filter->augmented().mean[0] - driven.now().T_odom_body.p.x() - apart_m;
  EXPECT_LT(std::abs(off_m), 0.1) << "as far from the vehicle as it was measured to be";
}

}  // namespace
}  // namespace rali::odometry
