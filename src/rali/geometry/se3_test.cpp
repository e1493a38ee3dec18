#include "rali/geometry/se3.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::geometry {
namespace {

SE3 random_pose(Rng& rng) {
  return {so3_exp(Vec3(rng.normal(), rng.normal(), rng.normal())),
          10.0 * Vec3(rng.normal(), rng.normal(), rng.normal())};
}

double distance(const SE3& a, const SE3& b) { return (a.R - b.R).norm() + (a.p - b.p).norm(); }

TEST(Se3, composes_transforms_in_the_order_of_their_frame_names) {
  const SE3 T_a_b{so3_exp(Vec3(0.0, 0.0, M_PI / 2)), Vec3(1.0, 0.0, 0.0)};
  const SE3 T_b_c{Mat3::Identity(), Vec3(2.0, 0.0, 0.0)};
  // b's x axis is a's y axis: c's origin is at (1, 2) in a.
  EXPECT_LT(((T_a_b * T_b_c).p - Vec3(1.0, 2.0, 0.0)).norm(), 1e-15);
  EXPECT_LT((T_a_b * Vec3(3.0, 0.0, 5.0) - Vec3(1.0, 3.0, 5.0)).norm(), 1e-14);
}

TEST(Se3, group_laws_hold) {
  Rng rng(1, "se3");
  for (int k = 0; k < 50; ++k) {
    const SE3 A = random_pose(rng);
    const SE3 B = random_pose(rng);
    const SE3 C = random_pose(rng);
    EXPECT_LT(distance((A * B) * C, A * (B * C)), 1e-13);
    EXPECT_LT(distance(A * A.inverse(), SE3{}), 1e-13);
    EXPECT_LT(distance((A * B).inverse(), B.inverse() * A.inverse()), 1e-13);
    const Vec3 p(rng.normal(), rng.normal(), rng.normal());
    EXPECT_LT(((A * B) * p - A * (B * p)).norm(), 1e-13);
  }
}

TEST(Se3, boxminus_undoes_boxplus) {
  Rng rng(2, "box");
  for (int k = 0; k < 50; ++k) {
    const SE3 A = random_pose(rng);
    const SE3 B = random_pose(rng);
    EXPECT_LT(distance(boxplus(A, boxminus(B, A)), B), 1e-13);
    Vec6 d;
    d << rng.normal(), rng.normal(), rng.normal(), rng.normal(), rng.normal(), rng.normal();
    d.head<3>() *= 0.7;
    if (d.head<3>().norm() > 3.1) continue;
    EXPECT_LT((boxminus(boxplus(A, d), A) - d).norm(), 1e-13);
  }
}

TEST(Se3, boxplus_rotates_in_the_body_frame_and_shifts_in_the_parent_frame) {
  const SE3 T{so3_exp(Vec3(0.0, 0.0, M_PI / 2)), Vec3(1.0, 1.0, 0.0)};
  Vec6 d;
  d << 0.1, 0.0, 0.0, 0.5, 0.0, 0.0;
  const SE3 moved = boxplus(T, d);
  EXPECT_LT((moved.p - Vec3(1.5, 1.0, 0.0)).norm(), 1e-15);  // along the outer x
  EXPECT_LT((moved.R.col(0) - T.R.col(0)).norm(), 1e-15);    // about the body's x
  EXPECT_LT((so3_log(T.R.transpose() * moved.R) - Vec3(0.1, 0.0, 0.0)).norm(), 1e-15);
}

TEST(Se3, interpolates_at_constant_rate) {
  const SE3 a{so3_exp(Vec3(0.0, 0.0, 0.2)), Vec3(1.0, 0.0, 0.0)};
  const SE3 b{so3_exp(Vec3(0.0, 0.0, 1.0)), Vec3(3.0, 4.0, 0.0)};
  EXPECT_LT(distance(interpolate(a, b, 0.0), a), 1e-14);
  EXPECT_LT(distance(interpolate(a, b, 1.0), b), 1e-14);
  const SE3 quarter = interpolate(a, b, 0.25);
  EXPECT_LT((so3_log(quarter.R) - Vec3(0.0, 0.0, 0.4)).norm(), 1e-14);
  EXPECT_LT((quarter.p - Vec3(1.5, 1.0, 0.0)).norm(), 1e-15);
  const SE3 before = interpolate(a, b, -0.5);  // extrapolates
  EXPECT_LT((so3_log(before.R) - Vec3(0.0, 0.0, -0.2)).norm(), 1e-14);
  EXPECT_LT((before.p - Vec3(0.0, -2.0, 0.0)).norm(), 1e-15);
}

TEST(Se3, ros_covariance_has_position_first_and_rotation_about_fixed_axes) {
  // The body's roll is uncertain and its x axis points along the outer y, so the uncertain rotation
  // is about the outer y.
  Mat6 cov = Mat6::Zero();
  cov.diagonal() << 0.04, 0.0, 0.0, 1.0, 2.0, 3.0;
  cov(0, 3) = cov(3, 0) = 0.1;
  const Mat6 ros = covariance_fixed_axes(cov, so3_exp(Vec3(0.0, 0.0, M_PI / 2)));
  Mat6 expected = Mat6::Zero();
  expected.diagonal() << 1.0, 2.0, 3.0, 0.0, 0.04, 0.0;
  expected(0, 4) = expected(4, 0) = 0.1;
  EXPECT_LT((ros - expected).norm(), 1e-15);
}

TEST(Se3, ros_covariance_is_that_of_sampled_poses) {
  Rng rng(3, "cov");
  const SE3 T = random_pose(rng);
  Mat6 L = Mat6::Zero();
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c <= r; ++c) L(r, c) = 0.01 * rng.normal();
  }
  Mat6 sampled = Mat6::Zero();
  constexpr int kN = 4000;
  for (int k = 0; k < kN; ++k) {
    Vec6 z;
    for (int j = 0; j < 6; ++j) z[j] = rng.normal();
    const SE3 seen = boxplus(T, L * z);
    Vec6 e;
    e << seen.p - T.p, so3_log(seen.R * T.R.transpose());
    sampled += e * e.transpose() / kN;
  }
  const Mat6 claimed = covariance_fixed_axes(L * L.transpose(), T.R);
  EXPECT_LT((sampled - claimed).norm(), 0.1 * claimed.norm());
}

}  // namespace
}  // namespace rali::geometry
