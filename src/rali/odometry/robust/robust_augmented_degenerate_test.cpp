#include <cmath>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "rali/odometry/robust/driven_for_test.hpp"

namespace rali::odometry {
namespace {

using geometry::Mat3;
using geometry::Vec3;

constexpr double kScan_s = TestRoom::kScan_s;

TEST(RobustAugmentedFilter, in_a_room_widen_changes_no_covariance) {
  Driven driven(small_room(), 18, true);
  EXPECT_FALSE(driven.filter->degenerate_axis());
  const Eigen::MatrixXd before = driven.filter->covariance(unit_rows(*driven.filter));
  driven.filter->widen(9.0);
  EXPECT_EQ(driven.filter->covariance(unit_rows(*driven.filter)), before);
}

TEST(RobustAugmentedFilter, widens_only_position_and_velocity_along_a_degenerate_tunnel_axis) {
  Driven driven(tunnel(), 25, true);
  const auto axis = driven.filter->degenerate_axis();
  ASSERT_TRUE(axis);
  EXPECT_GT(std::abs(axis->x()), 0.999);
  const Eigen::MatrixXd before = driven.filter->covariance(unit_rows(*driven.filter));
  driven.filter->widen(4.0);
  Eigen::MatrixXd expected = before;
  for (const int block : {3, 6}) {
    const double var = axis->dot(before.block<3, 3>(block, block) * *axis);
    EXPECT_GT(var, 0.0);
    expected.block<3, 3>(block, block) += 3.0 * var * *axis * axis->transpose();
  }
  const Eigen::MatrixXd after = driven.filter->covariance(unit_rows(*driven.filter));
  // The bend measured from straight walls is noise; it turns by less than a milliradian.
  EXPECT_LT((after - expected).cwiseAbs().maxCoeff(),
            1e-3 * (after - before).cwiseAbs().maxCoeff());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(after);
  EXPECT_GT(solver.eigenvalues().minCoeff(), -1e-15);
  EXPECT_EQ(driven.filter->position_covariance(), Mat3(after.block<3, 3>(3, 3)));
}

TEST(RobustAugmentedFilter, widen_limits_the_speed_sigma_to_3_m_per_s) {
  Driven driven(tunnel(), 25, true);
  const auto axis = driven.filter->degenerate_axis();
  ASSERT_TRUE(axis);
  for (int k = 0; k < 20; ++k) driven.filter->widen(16.0);
  AugmentedMeasurement speed;
  speed.d_velocity = axis->transpose();
  EXPECT_NEAR(std::sqrt(driven.filter->covariance(AugmentedRowList{speed})(0, 0)), 3.0, 1e-6);
  AugmentedMeasurement place;
  place.d_pose.tail<3>() = axis->transpose();
  EXPECT_GT(driven.filter->covariance(AugmentedRowList{place})(0, 0), 1e6);
}

TEST(RobustAugmentedFilter, map_error_acts_across_a_tunnel_but_not_along_it) {
  // Along the axis the map does not constrain the pose: a range there moves only the pose.
  Driven driven(tunnel(), 25, true);
  const auto axis = driven.filter->degenerate_axis();
  ASSERT_TRUE(axis);
  AugmentedMeasurement along;
  along.d_pose.tail<3>() = axis->transpose();
  AugmentedMeasurement across;
  across.d_pose.tail<3>() = Vec3::UnitZ().cross(*axis).transpose();
  EXPECT_LT(map_error(*driven.filter, along), 0.02 * map_error(*driven.filter, across));
  along.residual = 0.1;
  const double var = driven.filter->covariance(AugmentedRowList{along})(0, 0);
  const Vec3 shift = driven.filter->apply(along, 1e-4);
  EXPECT_NEAR(shift.dot(*axis), 0.1 * var / (var + 1e-4), 1e-3);
  EXPECT_GT(shift.dot(*axis), 0.02);
}

TEST(RobustAugmentedFilter, a_degenerate_scan_does_not_change_landmarks_and_biases) {
  // They depend on the pose along the tunnel; lateral information from the walls would reach them
  // only through the slope of the covariance.
  Driven driven(tunnel(), 25, true);
  const auto axis = driven.filter->degenerate_axis();
  ASSERT_TRUE(axis);
  add_landmark_and_bias(*driven.filter);
  AugmentedMeasurement range;
  range.d_pose.tail<3>() = -axis->transpose();
  range.d_augmented = AugmentedStates::Vector::Zero(4);
  range.d_augmented.head<3>() = *axis;
  range.d_augmented[3] = 1.0;
  range.residual = 0.2;
  static_cast<void>(driven.filter->apply(range, 1e-4));
  const AugmentedStates before = driven.filter->augmented();
  const double expected_m2 = driven.filter->variance(range);
  static_cast<void>(driven.scan());
  EXPECT_EQ(driven.filter->augmented().mean, before.mean);
  EXPECT_EQ(driven.filter->augmented().covariance, before.covariance);
  // Their correlation with the pose along the tunnel is kept: the next range fits the prediction.
  EXPECT_LT(driven.filter->variance(range), expected_m2 + 1e-3);
}

TEST(RobustAugmentedFilter, a_long_correction_along_a_tunnel_adds_lateral_variance) {
  // 0.02 of the length beyond 0.3 m.
  Driven driven(tunnel(), 25, true);
  const auto axis = driven.filter->degenerate_axis();
  ASSERT_TRUE(axis);
  const Vec3 across = Vec3::UnitZ().cross(*axis);
  const auto variance_across = [&] {
    return across.dot(driven.filter->position_covariance() * across);
  };
  AugmentedMeasurement along;
  along.d_pose.tail<3>() = axis->transpose();
  along.residual = 2.0;
  const double before_m2 = variance_across();
  const Vec3 shift = driven.filter->apply(along, 1e-6);
  ASSERT_NEAR(shift.norm(), 2.0, 0.1);
  EXPECT_NEAR(variance_across() - before_m2, std::pow(0.02 * (shift.norm() - 0.3), 2), 2e-5);
}

TEST(RobustAugmentedFilter, degenerate_scans_keep_the_range_correction_along_the_tunnel) {
  Driven plain(tunnel(), 25, true);
  Driven pushed(tunnel(), 25, true);
  const auto axis = pushed.filter->degenerate_axis();
  ASSERT_TRUE(axis);
  AugmentedMeasurement along;
  along.d_pose.tail<3>() = axis->transpose();
  along.residual = 0.3;
  const Vec3 shift = pushed.filter->apply(along, 1e-4);
  const Vec3 speed = pushed.now().v_odom_mps - plain.now().v_odom_mps;
  Vec3 expected = shift;
  for (int k = 1; k <= 3; ++k) {
    const ScanResult a = plain.scan();
    const ScanResult b = pushed.scan();
    expected += kScan_s * speed;
    const Vec3 apart = b.T_odom_body.p - a.T_odom_body.p;
    EXPECT_NEAR(apart.dot(*axis), expected.dot(*axis), 0.03 * expected.norm()) << k;
    EXPECT_LT((apart - apart.dot(*axis) * *axis).norm(), 0.01) << k;
  }
}

}  // namespace
}  // namespace rali::odometry
