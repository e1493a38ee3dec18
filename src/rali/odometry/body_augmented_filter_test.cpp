#include "rali/odometry/body_augmented_filter.hpp"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/odometry/augmented_filter_for_test.hpp"

namespace rali::odometry {
namespace {

using geometry::Mat3;
using geometry::Mat6;
using geometry::SE3;
using geometry::so3_exp;
using geometry::Vec3;
using geometry::Vec6;

/// An IMU that is rotated and far from the body's origin, and a body with an arbitrary start pose.
struct Mounted {
  SE3 T_imu_body{so3_exp(Vec3(0.1, -0.4, 1.2)), Vec3(0.7, -0.3, 0.5)};
  SE3 T_odom_inner{so3_exp(Vec3(0.0, 0.0, -0.9)), Vec3(4.0, -2.0, 1.0)};
  DenseAugmentedFilter inner;
  BodyAugmentedFilter body{inner, T_imu_body};

  Mounted() {
    body.set_odom(T_odom_inner);
    inner.now.T_odom_body = {so3_exp(Vec3(0.2, 0.3, -0.5)), Vec3(1.0, 2.0, 0.3)};
    inner.now.v_odom_mps = Vec3(0.8, -0.2, 0.1);
    inner.now.w_body_radps = Vec3(0.05, -0.1, 0.4);
    static_cast<void>(body.advance_to(Time{}));
  }

  [[nodiscard]] SE3 T_odom_body(const SE3& T_inner_imu) const {
    return T_odom_inner * T_inner_imu * T_imu_body;
  }

  [[nodiscard]] Mat6 jacobian() const {
    return body_jacobian(inner.now.T_odom_body, T_imu_body, T_odom_inner.R);
  }
};

void fill_covariance(DenseAugmentedFilter& filter, double size, std::uint64_t seed) {
  Rng rng(seed, "covariance");
  Eigen::MatrixXd A(filter.P.rows(), filter.P.cols());
  for (int i = 0; i < A.size(); ++i) A.data()[i] = size * rng.normal();
  filter.P = A * A.transpose();
}

TEST(BodyAugmentedFilter, reports_pose_and_velocity_of_the_body_not_the_imu) {
  Mounted m;
  const auto before = m.body.advance_to(Time{});
  ASSERT_TRUE(before);
  EXPECT_LT((before->T_odom_body.p - m.T_odom_body(m.inner.now.T_odom_body).p).norm(), 1e-12);
  // Speed by central differences of the body's path.
  constexpr double kStep_s = 1e-5;
  const auto at = [&](double t_s) {
    SE3 T = m.inner.now.T_odom_body;
    T.p += t_s * m.inner.now.v_odom_mps;
    T.R = T.R * so3_exp(t_s * m.inner.now.w_body_radps);
    return m.T_odom_body(T);
  };
  const Vec3 v = (at(kStep_s).p - at(-kStep_s).p) / (2.0 * kStep_s);
  const Vec3 w = geometry::so3_log(at(-kStep_s).R.transpose() * at(kStep_s).R) / (2.0 * kStep_s);
  EXPECT_LT((before->v_odom_mps - v).norm(), 1e-8);
  EXPECT_LT((before->w_body_radps - w).norm(), 1e-8);
}

TEST(BodyAugmentedFilter, converts_measurement_jacobians_to_the_inner_pose) {
  // Of the distance from an antenna on the body to a point in odom, by the inner pose.
  Mounted m;
  const Vec3 lever(0.3, 0.2, 0.9);
  const Vec3 place(15.0, 6.0, 2.0);
  const auto distance = [&](const SE3& T_inner_imu) {
    return (m.T_odom_body(T_inner_imu) * lever - place).norm();
  };
  const SE3 T = m.T_odom_body(m.inner.now.T_odom_body);
  const Vec3 e = (T * lever - place).normalized();
  AugmentedMeasurement in;
  in.d_pose.head<3>() = -e.transpose() * T.R * geometry::skew(lever);
  in.d_pose.tail<3>() = e.transpose();
  in.d_velocity = Eigen::RowVector3d(0.3, -0.5, 0.7);
  static_cast<void>(m.body.apply(in, 1.0));
  ASSERT_EQ(m.inner.applied.size(), 1U);
  const AugmentedMeasurement& seen = m.inner.applied[0];
  constexpr double kStep = 1e-6;
  const SE3 T_inner = Mounted().inner.now.T_odom_body;
  for (int k = 0; k < 6; ++k) {
    const Vec6 d = kStep * Vec6::Unit(k);
    const double numeric =
        (distance(geometry::boxplus(T_inner, d)) - distance(geometry::boxplus(T_inner, -d))) /
        (2.0 * kStep);
    EXPECT_NEAR(seen.d_pose[k], numeric, 1e-8) << k;
  }
  // A derivative by the velocity in odom is that by the inner velocity, rotated.
  EXPECT_LT((seen.d_velocity - in.d_velocity * m.T_odom_inner.R).norm(), 1e-12);
}

TEST(BodyAugmentedFilter, update_equals_that_of_a_filter_in_the_body_frame) {
  Mounted m;
  fill_covariance(m.inner, 0.02, 5);
  const Mat6 J = m.jacobian();
  DenseAugmentedFilter plain;
  plain.now.T_odom_body = m.T_odom_body(m.inner.now.T_odom_body);
  plain.P.topLeftCorner<6, 6>() = J * m.inner.P.topLeftCorner<6, 6>() * J.transpose();
  AugmentedMeasurement in;
  in.d_pose << 0.4, -0.2, 0.1, 0.6, 0.64, 0.48;
  in.residual = 1e-4;  // second-order terms are 1e-8 of it
  EXPECT_NEAR(m.body.variance(in), plain.variance(in), 1e-12);
  static_cast<void>(m.body.apply(in, 0.01));
  static_cast<void>(plain.apply(in, 0.01));
  const auto after = m.body.advance_to(Time{});
  ASSERT_TRUE(after);
  const Vec6 apart = geometry::boxminus(after->T_odom_body, plain.now.T_odom_body);
  EXPECT_LT(apart.norm(), 1e-8);
}

TEST(BodyAugmentedFilter, reports_position_corrections_in_the_odom_frame_of_the_body) {
  // Only the position is uncertain: 0.3 m along the inner x, which is odom rotated by -0.9 rad.
  Mounted m;
  m.inner.P(3, 3) = 0.09;
  const Vec3 along = m.T_odom_inner.R.col(0);
  AugmentedMeasurement in;
  in.d_pose.tail<3>() = along.transpose();
  in.residual = 0.2;
  const Vec3 shift = m.body.apply(in, 0.01);  // gain 0.9
  EXPECT_LT((shift - 0.18 * along).norm(), 1e-12);
}

TEST(BodyAugmentedFilter, passes_augmented_states_through_unchanged) {
  Mounted m;
  AugmentedStates::Vector mean(2);
  mean << 1.5, -2.5;
  AugmentedStates::Matrix covariance = AugmentedStates::Matrix::Identity(2, 2);
  EXPECT_EQ(m.body.add_states(mean, covariance, {}), 0);
  m.body.walk_side(1, 0.25);
  EXPECT_EQ(m.body.augmented().mean, mean);
  EXPECT_EQ(m.body.augmented().covariance(1, 1), 1.25);
  m.body.remove_states(0, 1);
  EXPECT_EQ(m.body.augmented().size(), 1);
  EXPECT_EQ(m.body.augmented().mean[0], -2.5);
  m.body.widen(4.0);
  EXPECT_EQ(m.inner.widened, 4.0);
}

TEST(BodyAugmentedFilter, rotates_axes_and_covariances_into_the_odom_frame_of_the_body) {
  Mounted m;
  EXPECT_FALSE(m.body.degenerate_axis());
  m.inner.axis = Vec3::UnitX();
  ASSERT_TRUE(m.body.degenerate_axis());
  EXPECT_LT((*m.body.degenerate_axis() - m.T_odom_inner.R.col(0)).norm(), 1e-12);
  m.inner.P(3, 3) = 4.0;
  const Vec3 along = m.T_odom_inner.R.col(0);
  EXPECT_LT((m.body.position_covariance() - 4.0 * along * along.transpose()).norm(), 1e-12);
}

TEST(BodyAugmentedFilter, reports_no_state_before_the_filter_is_initialised) {
  Mounted m;
  m.inner.found_itself = false;
  EXPECT_FALSE(m.body.advance_to(Time::from_s(1.0)));
}

}  // namespace
}  // namespace rali::odometry
