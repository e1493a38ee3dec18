#include <cmath>
#include <string>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/odometry/robust/driven_for_test.hpp"

namespace rali::odometry {
namespace {

using geometry::SE3;
using geometry::Vec3;
using geometry::Vec6;

constexpr double kScan_s = TestRoom::kScan_s;

/// A measurement that depends on all states.
AugmentedMeasurement any_measurement(const AugmentedFilter& filter, std::uint64_t seed,
                                     double residual) {
  Rng rng(seed, "measurement");
  AugmentedMeasurement m;
  for (int k = 0; k < 6; ++k) m.d_pose[k] = rng.normal();
  for (int k = 0; k < 3; ++k) m.d_velocity[k] = 0.1 * rng.normal();
  m.d_augmented.resize(filter.augmented().size());
  for (int k = 0; k < m.d_augmented.size(); ++k) m.d_augmented[k] = rng.normal();
  m.residual = residual;
  return m;
}

class RobustAugmented : public testing::TestWithParam<bool> {
 protected:
  /// Means are exact to second order of residuals of 1 mm.
  static constexpr double kMean = 1e-5;

  /// Without inertial data the velocity is in the body: after a shift of a millimetre, its
  /// covariance in odom is rotated by another attitude.
  static double covariance_fraction() { return GetParam() ? 1e-5 : 6e-3; }
};

TEST_P(RobustAugmented, updates_of_pose_velocity_and_augmented_states_match_a_dense_filter) {
  Driven driven = under_way(GetParam());
  add_landmark_and_bias(*driven.filter);
  for (std::uint64_t k = 0; k < 6; ++k) {
    DenseAugmentedFilter dense = textbook(driven);
    const AugmentedMeasurement m =
        any_measurement(*driven.filter, k, 1e-3 * static_cast<double>(k % 3));
    const double map_m2 = map_error(*driven.filter, m);
    EXPECT_GE(map_m2, 0.0);
    const Vec3 shift = driven.filter->apply(m, 0.02);
    const Vec3 expected = dense.apply(m, 0.02 + map_m2);  // the map's error acts as noise
    EXPECT_LT((shift - expected).norm(), 1e-9);
    expect_same(driven, dense, kMean, covariance_fraction());
  }
}

TEST_P(RobustAugmented, considered_states_move_only_along_estimated_directions) {
  Driven driven = under_way(GetParam());
  add_landmark_and_bias(*driven.filter);
  const Vec3 along = Vec3(0.8, 0.6, 0.0);
  for (std::uint64_t k = 0; k < 4; ++k) {
    DenseAugmentedFilter dense = textbook(driven);
    AugmentedMeasurement m = any_measurement(*driven.filter, 10 + k, 1e-3);
    m.considered = 0;
    m.estimates = along * along.transpose();
    const double R = 0.02 + map_error(*driven.filter, m);
    const Vec3 before = driven.filter->augmented().mean.head<3>();
    static_cast<void>(driven.filter->apply(m, 0.02));
    static_cast<void>(dense.apply(m, R));
    const Vec3 moved = driven.filter->augmented().mean.head<3>() - before;
    EXPECT_GT(std::abs(moved.dot(along)), 1e-9);
    EXPECT_LT(moved.cross(along).norm(), 1e-12);
    expect_same(driven, dense, kMean, covariance_fraction());
  }
}

TEST_P(RobustAugmented, adding_random_walk_and_removing_states_match_a_dense_filter) {
  Driven driven = under_way(GetParam());
  add_landmark_and_bias(*driven.filter);
  DenseAugmentedFilter dense = textbook(driven);
  for (AugmentedFilter* filter : {driven.filter, static_cast<AugmentedFilter*>(&dense)}) {
    filter->walk_side(3, 0.04);
    AugmentedStates::Vector mean(2);
    mean << -1.0, 2.0;
    AugmentedStates::Matrix uncertainty = AugmentedStates::Matrix::Identity(2, 2);
    uncertainty(0, 1) = uncertainty(1, 0) = 0.5;
    EXPECT_EQ(filter->add_states(mean, uncertainty, {}), 4);
  }
  AugmentedMeasurement m = any_measurement(*driven.filter, 20, 1e-3);
  const double map_m2 = map_error(*driven.filter, m);
  static_cast<void>(driven.filter->apply(m, 0.01));
  static_cast<void>(dense.apply(m, 0.01 + map_m2));
  // The middle states are removed; correlations of the remaining ones are unchanged.
  driven.filter->remove_states(1, 3);
  dense.remove_states(1, 3);
  ASSERT_EQ(driven.filter->augmented().size(), 3);
  expect_same(driven, dense, kMean, covariance_fraction());
}

// Without correlation to the vehicle's error, the next measurement of a landmark initialised from
// here would correct the vehicle's position by its own estimate.
TEST_P(RobustAugmented, states_initialised_from_the_vehicle_are_correlated_with_its_error) {
  Driven driven = under_way(GetParam());
  add_landmark_and_bias(*driven.filter);
  DenseAugmentedFilter dense = textbook(driven);
  AugmentedRowList rows = {any_measurement(*driven.filter, 40, 0.0),
                           any_measurement(*driven.filter, 41, 0.0)};
  AugmentedStates::Vector mean(2);
  mean << -1.0, 2.0;
  const AugmentedStates::Matrix apart = 0.04 * AugmentedStates::Matrix::Identity(2, 2);
  EXPECT_EQ(driven.filter->add_states(mean, apart, rows), 4);
  EXPECT_EQ(dense.add_states(mean, apart, rows), 4);
  expect_same(driven, dense, kMean, covariance_fraction());
  // Relative to the vehicle, only the measurement noise is uncertain.
  for (int k = 0; k < 2; ++k) {
    AugmentedMeasurement& row = rows[static_cast<std::size_t>(k)];
    row.d_augmented.conservativeResize(6);
    row.d_augmented.tail(2).setZero();
    row.d_augmented[4 + k] = -1.0;
  }
  EXPECT_LT((driven.filter->covariance(rows) - apart).norm(), 1e-9);
}

TEST_P(RobustAugmented, replacing_estimates_updates_correlated_states_like_a_dense_filter) {
  Driven driven = under_way(GetParam());
  add_landmark_and_bias(*driven.filter);
  static_cast<void>(driven.filter->apply(any_measurement(*driven.filter, 30, 0.0), 0.01));
  DenseAugmentedFilter dense = textbook(driven);
  AugmentedRowList rows = {any_measurement(*driven.filter, 31, 0.0),
                           any_measurement(*driven.filter, 32, 0.0),
                           any_measurement(*driven.filter, 33, 0.0)};
  EXPECT_LT((driven.filter->covariance(rows) - dense.covariance(rows)).norm(),
            1e-9 * dense.covariance(rows).norm());
  // Narrower in one, wider in another; and a row that duplicates the first.
  AugmentedStates::Matrix given = dense.covariance(rows);
  given.row(0) *= 0.5;
  given.col(0) *= 0.5;
  given.row(2) *= 2.0;
  given.col(2) *= 2.0;
  AugmentedStates::Vector shift(3);
  shift << 1e-3, -2e-3, 5e-4;
  const Vec3 moved = driven.filter->replace(rows, shift, given);
  const Vec3 expected = dense.replace(rows, shift, given);
  EXPECT_LT((moved - expected).norm(), 1e-9);
  expect_same(driven, dense, kMean, covariance_fraction());
  EXPECT_LT((driven.filter->covariance(rows) - given).norm(), covariance_fraction() * given.norm());
}

TEST_P(RobustAugmented, duplicate_rows_in_replace_count_once) {
  Driven once = under_way(GetParam());
  Driven twice = under_way(GetParam());
  for (Driven* d : {&once, &twice}) add_landmark_and_bias(*d->filter);
  const AugmentedMeasurement m = any_measurement(*once.filter, 40, 0.0);
  const double before_m2 = once.filter->covariance(AugmentedRowList{m})(0, 0);
  AugmentedStates::Vector shift = AugmentedStates::Vector::Constant(1, 1e-3);
  AugmentedStates::Matrix half = AugmentedStates::Matrix::Constant(1, 1, 0.5 * before_m2);
  static_cast<void>(once.filter->replace({m}, shift, half));
  shift = AugmentedStates::Vector::Constant(2, 1e-3);
  half = AugmentedStates::Matrix::Constant(2, 2, 0.5 * before_m2);
  static_cast<void>(twice.filter->replace({m, m}, shift, half));
  EXPECT_NEAR(once.filter->covariance(AugmentedRowList{m})(0, 0), 0.5 * before_m2,
              1e-4 * before_m2);
  DenseAugmentedFilter dense = textbook(once);
  expect_same(twice, dense, kMean, 1e-6);
}

std::string name_of(const testing::TestParamInfo<bool>& with_imu) {
  return with_imu.param ? "inertial" : "lidar_only";
}

INSTANTIATE_TEST_SUITE_P(WithAndWithoutInertialData, RobustAugmented, testing::Bool(), name_of);

TEST(RobustAugmentedFilter, a_scan_corrects_augmented_states_through_their_correlations) {
  Driven driven = under_way(true);
  add_landmark_and_bias(*driven.filter);
  AugmentedMeasurement range;  // correlates the landmark with the vehicle's position
  range.d_pose.tail<3>() = Eigen::RowVector3d(-0.9, -0.4, 0.1);
  range.d_augmented = AugmentedStates::Vector::Zero(4);
  range.d_augmented.head<3>() = Vec3(0.9, 0.4, -0.1);
  static_cast<void>(driven.filter->apply(range, 1e-6));
  driven.imu_until(kScan_s * (driven.scans + 1));
  driven.t_end = driven.t_end + Duration::from_s(kScan_s);
  ASSERT_TRUE(driven.filter->advance_to(driven.t_end));
  DenseAugmentedFilter dense = textbook(driven);
  static_cast<void>(driven.scan());
  // Regression on the pose and the speed after the scan.
  AugmentedRowList own = unit_rows(dense);
  own.resize(DenseAugmentedFilter::kOwn);
  const Moment after = driven.now();
  AugmentedStates::Vector shift(DenseAugmentedFilter::kOwn);
  shift << geometry::boxminus(after.T_odom_body, dense.now.T_odom_body),
      after.v_odom_mps - dense.now.v_odom_mps;
  const AugmentedStates::Vector place = dense.known.mean;
  static_cast<void>(dense.replace(own, shift, driven.filter->covariance(own)));
  EXPECT_GT((dense.known.mean - place).norm(), 1e-5);
  expect_same(driven, dense, 0.02, 0.02);
}

TEST(RobustAugmentedFilter, propagation_carries_velocity_correlation_to_the_position) {
  Driven driven(small_room(), 18, true);
  add_landmark_and_bias(*driven.filter);
  AugmentedMeasurement m;
  m.d_velocity = Eigen::RowVector3d(1.0, 0.0, 0.0);
  m.d_augmented = AugmentedStates::Vector::Zero(4);
  m.d_augmented[3] = -1.0;
  static_cast<void>(driven.filter->apply(m, 1e-6));  // correlates the bias fully with the speed
  const Eigen::MatrixXd before = driven.filter->covariance(unit_rows(*driven.filter));
  constexpr double kStep_s = 0.05;
  driven.imu_until(driven.t_end.s() + kStep_s);
  const Moment then = *driven.filter->advance_to(driven.t_end + Duration::from_s(kStep_s));
  const Eigen::MatrixXd after = driven.filter->covariance(unit_rows(*driven.filter));
  // cov(p + dt v, bias) = cov(p, bias) + dt cov(v, bias); tilt and biases add a tenth of a percent.
  const int bias = DenseAugmentedFilter::kOwn + 3;
  const Vec3 grown = after.block<3, 1>(3, bias) - before.block<3, 1>(3, bias);
  const Vec3 expected = kStep_s * before.block<3, 1>(6, bias);
  EXPECT_GT(expected.norm(), 1e-8);
  EXPECT_LT((grown - expected).norm(), 0.02 * expected.norm());
  EXPECT_EQ(after.bottomRightCorner(4, 4), before.bottomRightCorner(4, 4));
  EXPECT_EQ(then.t, driven.t_end + Duration::from_s(kStep_s));
}

TEST(RobustAugmentedFilter, advancing_between_scans_does_not_change_the_trajectory) {
  Driven plain(small_room(), 16, true);
  Driven asked(small_room(), 16, true);
  for (int k = 0; k < 4; ++k) {
    for (Driven* d : {&plain, &asked}) d->imu_until(kScan_s * (d->scans + 1));
    for (const double part : {0.31, 0.32, 0.8}) {
      const Time t = asked.t_end + Duration::from_s(part * kScan_s);
      const auto then = asked.filter->advance_to(t);
      ASSERT_TRUE(then);
      const SE3 truth = asked.room.pose(t.s());
      EXPECT_LT((then->T_odom_body.p - truth.p).norm(), 0.05);
      EXPECT_EQ(then->t, t);
    }
    const ScanResult a = plain.scan();
    const ScanResult b = asked.scan();
    const Vec6 apart = geometry::boxminus(a.T_odom_body, b.T_odom_body);
    EXPECT_LT(apart.norm(), 2e-4) << k;  // samples are split at the times of the calls
  }
}

TEST(RobustAugmentedFilter, returns_no_state_before_initialisation_or_over_0_1_s_back) {
  Driven waiting(small_room(), 3, true);
  EXPECT_FALSE(waiting.filter->advance_to(waiting.t_end));
  Driven driven(small_room(), 20, true);
  const Moment now = driven.now();
  ASSERT_GT(now.v_odom_mps.norm(), 0.3);
  EXPECT_FALSE(driven.filter->advance_to(driven.t_end - Duration::from_s(0.11)));
  const auto then = driven.filter->advance_to(driven.t_end - Duration::from_s(0.09));
  ASSERT_TRUE(then);
  const Vec3 back = now.T_odom_body.p - then->T_odom_body.p;
  EXPECT_LT((back - 0.09 * now.v_odom_mps).norm(), 1e-9);
  const SE3 truth = driven.room.pose(driven.t_end.s() - 0.09);
  EXPECT_LT((then->T_odom_body.p - truth.p).norm(), 0.03);
}

TEST(RobustAugmentedFilter, refuses_states_beyond_its_capacity) {
  Driven driven(small_room(), 1, false);
  AugmentedStates::Vector mean = AugmentedStates::Vector::Zero(AugmentedStates::kMax - 1);
  const AugmentedStates::Matrix uncertainty =
      AugmentedStates::Matrix::Identity(AugmentedStates::kMax - 1, AugmentedStates::kMax - 1);
  EXPECT_EQ(driven.filter->add_states(mean, uncertainty, {}), 0);
  mean = AugmentedStates::Vector::Zero(2);
  EXPECT_EQ(driven.filter->add_states(mean, AugmentedStates::Matrix::Identity(2, 2), {}), -1);
  EXPECT_EQ(driven.filter->augmented().size(), AugmentedStates::kMax - 1);
}

TEST(RobustAugmentedFilter, counts_map_surfaces_crossed_by_a_line_of_sight) {
  TestRoom room;
  room.rest_s = 100.0;
  Driven driven(room, 12, true);
  const AugmentedFilter& filter = *driven.filter;
  const Vec3 inside(1.0, 0.5, 0.0);
  EXPECT_EQ(filter.surfaces_between(inside, Vec3(2.0, 3.0, 0.2)), 0);
  EXPECT_EQ(filter.surfaces_between(inside, Vec3(1.2, 8.0, 0.1)), 1);  // wall at y = 6.5
  EXPECT_EQ(filter.surfaces_between(Vec3(1.2, 8.0, 0.1), inside), 1);  // and back
  EXPECT_EQ(filter.surfaces_between(Vec3(1.1, -6.0, 0.1), Vec3(1.2, 8.0, 0.1)), 2);
  EXPECT_EQ(filter.surfaces_between(inside, inside), 0);
}

}  // namespace
}  // namespace rali::odometry
