#include <cmath>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "rali/odometry/robust/driven_for_test.hpp"

namespace rali::odometry {
namespace {

using geometry::Mat3;
using geometry::Vec3;

constexpr double kSweep_s = TestRoom::kSweep_s;

TEST(RobustSideFilter, in_a_room_no_direction_is_blind_and_nothing_is_widened) {
  Driven driven(small_room(), 18, true);
  EXPECT_FALSE(driven.filter->blind_axis());
  const Eigen::MatrixXd before = driven.filter->covariance(unit_rows(*driven.filter));
  driven.filter->widen(9.0);
  EXPECT_EQ(driven.filter->covariance(unit_rows(*driven.filter)), before);
}

TEST(RobustSideFilter, widens_place_and_speed_along_the_blind_axis_of_a_tunnel_and_nothing_else) {
  Driven driven(tunnel(), 25, true);
  const auto axis = driven.filter->blind_axis();
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
  // What is seen of a bend in straight walls is noise; it turns by less than a milliradian.
  EXPECT_LT((after - expected).cwiseAbs().maxCoeff(),
            1e-3 * (after - before).cwiseAbs().maxCoeff());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(after);
  EXPECT_GT(solver.eigenvalues().minCoeff(), -1e-15);
  EXPECT_EQ(driven.filter->position_covariance(), Mat3(after.block<3, 3>(3, 3)));
}

TEST(RobustSideFilter, the_speed_is_never_more_in_doubt_than_that_of_the_first_scan) {
  Driven driven(tunnel(), 25, true);
  const auto axis = driven.filter->blind_axis();
  ASSERT_TRUE(axis);
  for (int k = 0; k < 20; ++k) driven.filter->widen(16.0);
  SideMeasurement speed;
  speed.d_velocity = axis->transpose();
  EXPECT_NEAR(std::sqrt(driven.filter->covariance(SideRowList{speed})(0, 0)), 3.0, 1e-6);
  SideMeasurement place;
  place.d_pose.tail<3>() = axis->transpose();
  EXPECT_GT(driven.filter->covariance(SideRowList{place})(0, 0), 1e6);
}

TEST(RobustSideFilter, the_map_is_wrong_across_a_tunnel_and_not_along_it) {
  // Along the axis the pose does not hang on the map: a range there is all the pose's to follow.
  Driven driven(tunnel(), 25, true);
  const auto axis = driven.filter->blind_axis();
  ASSERT_TRUE(axis);
  SideMeasurement along;
  along.d_pose.tail<3>() = axis->transpose();
  SideMeasurement across;
  across.d_pose.tail<3>() = Vec3::UnitZ().cross(*axis).transpose();
  EXPECT_LT(map_error(*driven.filter, along), 0.02 * map_error(*driven.filter, across));
  along.residual = 0.1;
  const double var = driven.filter->covariance(SideRowList{along})(0, 0);
  const Vec3 shift = driven.filter->apply(along, 1e-4);
  EXPECT_NEAR(shift.dot(*axis), 0.1 * var / (var + 1e-4), 1e-3);
  EXPECT_GT(shift.dot(*axis), 0.02);
}

TEST(RobustSideFilter, a_blind_sweep_tells_nothing_of_places_and_biases) {
  // They hang on the pose along the tunnel; what the walls say would reach them by the covariance's
  // slope only.
  Driven driven(tunnel(), 25, true);
  const auto axis = driven.filter->blind_axis();
  ASSERT_TRUE(axis);
  add_place_and_bias(*driven.filter);
  SideMeasurement range;
  range.d_pose.tail<3>() = -axis->transpose();
  range.d_side = SideStates::Vector::Zero(4);
  range.d_side.head<3>() = *axis;
  range.d_side[3] = 1.0;
  range.residual = 0.2;
  static_cast<void>(driven.filter->apply(range, 1e-4));
  const SideStates before = driven.filter->side();
  const double expected_m2 = driven.filter->variance(range);
  static_cast<void>(driven.sweep());
  EXPECT_EQ(driven.filter->side().mean, before.mean);
  EXPECT_EQ(driven.filter->side().covariance, before.covariance);
  // And what the pose shares with them along the tunnel stays: the next range is no surprise.
  EXPECT_LT(driven.filter->variance(range), expected_m2 + 1e-3);
}

TEST(RobustSideFilter, a_long_shift_along_a_tunnel_leaves_doubt_across_it) {
  // 0.02 of what it is longer than 0.3 m.
  Driven driven(tunnel(), 25, true);
  const auto axis = driven.filter->blind_axis();
  ASSERT_TRUE(axis);
  const Vec3 across = Vec3::UnitZ().cross(*axis);
  const auto variance_across = [&] {
    return across.dot(driven.filter->position_covariance() * across);
  };
  SideMeasurement along;
  along.d_pose.tail<3>() = axis->transpose();
  along.residual = 2.0;
  const double before_m2 = variance_across();
  const Vec3 shift = driven.filter->apply(along, 1e-6);
  ASSERT_NEAR(shift.norm(), 2.0, 0.1);
  EXPECT_NEAR(variance_across() - before_m2, std::pow(0.02 * (shift.norm() - 0.3), 2), 2e-5);
}

TEST(RobustSideFilter, a_blind_sweep_leaves_the_place_along_the_tunnel_as_ranges_left_it) {
  Driven plain(tunnel(), 25, true);
  Driven pushed(tunnel(), 25, true);
  const auto axis = pushed.filter->blind_axis();
  ASSERT_TRUE(axis);
  SideMeasurement along;
  along.d_pose.tail<3>() = axis->transpose();
  along.residual = 0.3;
  const Vec3 shift = pushed.filter->apply(along, 1e-4);
  const Vec3 speed = pushed.now().v_odom_mps - plain.now().v_odom_mps;
  Vec3 expected = shift;
  for (int k = 1; k <= 3; ++k) {
    const ScanResult a = plain.sweep();
    const ScanResult b = pushed.sweep();
    expected += kSweep_s * speed;
    const Vec3 apart = b.T_odom_body.p - a.T_odom_body.p;
    EXPECT_NEAR(apart.dot(*axis), expected.dot(*axis), 0.03 * expected.norm()) << k;
    EXPECT_LT((apart - apart.dot(*axis) * *axis).norm(), 0.01) << k;
  }
}

}  // namespace
}  // namespace rali::odometry
