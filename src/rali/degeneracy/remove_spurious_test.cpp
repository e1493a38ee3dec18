#include <array>
#include <vector>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/degeneracy/information.hpp"
#include "rali/degeneracy/plane_for_test.hpp"

namespace rali::degeneracy {
namespace {

using geometry::Mat3;
using geometry::Mat6;
using geometry::so3_exp;
using geometry::Vec3;
using geometry::Vec6;

// The downdate of T11: translation along x and yaw coupled, I = [[10, 5], [5, 100]].
struct Coupled {
  Mat6 I = Mat6::Zero();
  Vec6 b = Vec6::Zero();
  std::array<DirectionInfo, 6> directions{};

  Coupled() {
    I(3, 3) = 10.0;
    I(2, 2) = 100.0;
    I(3, 2) = I(2, 3) = 5.0;
    b(3) = 2.0;
    b(2) = -3.0;
    for (int k = 0; k < 6; ++k)
      directions[static_cast<std::size_t>(k)].direction_odom = Vec3::Unit(k % 3);
    directions[0].raw = 9.75;
  }
};

TEST(RemoveSpurious, downdates_marginal_information_to_zero_as_computed_by_hand) {
  Coupled c;
  c.directions[0].information = 0.0;
  remove_spurious(c.I, c.b, Mat3::Identity(), c.directions);
  EXPECT_NEAR(c.I(3, 3), 0.25, 1e-12);
  EXPECT_NEAR(c.I(2, 3), 5.0, 1e-12);
  EXPECT_NEAR(c.I(2, 2), 100.0, 1e-12);
  // u = (1, -0.05): u.b = 2.15 is removed from the translation, the rotation's part stays.
  EXPECT_NEAR(c.b(3), 2.0 - 2.15, 1e-12);
  EXPECT_NEAR(c.b(2), -3.0, 1e-12);
}

TEST(RemoveSpurious, halves_marginal_information_as_computed_by_hand) {
  Coupled c;
  c.directions[0].information = 4.875;
  remove_spurious(c.I, c.b, Mat3::Identity(), c.directions);
  EXPECT_NEAR(c.I(3, 3), 5.125, 1e-12);
  EXPECT_NEAR(c.I(2, 3), 5.0, 1e-12);
  EXPECT_NEAR(c.I(2, 2), 100.0, 1e-12);
  EXPECT_NEAR(c.b(3), 2.0 - 0.5 * 2.15, 1e-12);
}

TEST(RemoveSpurious, moves_along_the_direction_as_the_walls_say) {
  Coupled c;
  c.directions[0].information = 4.0;
  c.directions[0].wall_residual_m = 0.5;
  remove_spurious(c.I, c.b, Mat3::Identity(), c.directions);
  Vec6 u = Vec6::Zero();
  u(3) = 1.0;
  u(2) = -0.05;
  EXPECT_NEAR(u.dot(c.I * u), 4.0, 1e-12);
  EXPECT_NEAR(u.dot(c.b), 4.0 * 0.5, 1e-12);
  EXPECT_NEAR(c.b(2), -3.0, 1e-12) << "the rotation's part stays";
}

TEST(RemoveSpurious, changes_nothing_where_nothing_is_spurious) {
  Coupled c;
  c.directions[0].information = 9.75;
  const Mat6 before = c.I;
  remove_spurious(c.I, c.b, Mat3::Identity(), c.directions);
  EXPECT_EQ(c.I, before);
}

TEST(RemoveSpurious, keeps_the_system_positive_semidefinite_and_its_minimum_unchanged) {
  Rng rng(1, "downdate");
  for (int k = 0; k < 30; ++k) {
    Eigen::Matrix<double, 20, 6> J;
    for (int i = 0; i < J.size(); ++i) J.data()[i] = rng.normal();
    Mat6 I = J.transpose() * J;
    Vec6 x;
    for (int i = 0; i < 6; ++i) x[i] = rng.normal();
    Vec6 b = I * x;
    const Mat3 R = so3_exp(Vec3(rng.normal(), rng.normal(), rng.normal()));
    const Axes axes = so3_exp(Vec3(rng.normal(), rng.normal(), rng.normal()));
    std::vector<PlaneEvidence> planes{plane(Vec3::UnitX(), 5), plane(Vec3::UnitY(), 5)};
    for (PlaneEvidence& p : planes) {
      p.lever_odom_m = 3.0 * Vec3(rng.normal(), rng.normal(), rng.normal());
      p.weight = rng.uniform(0.0, 3e4);
    }
    const auto directions = direction_information(I, planes, R, axes, {});
    const Mat6 before = I;
    remove_spurious(I, b, R, directions);
    const double largest = before.trace();
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Mat6>(I).eigenvalues()[0], -1e-10 * largest);
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Mat6>(before - I).eigenvalues()[0], -1e-10 * largest);
    EXPECT_LT((I - I.transpose()).norm(), 1e-10 * largest);
    EXPECT_LT((I * x - b).norm(), 1e-8 * largest);  // the minimum is unchanged
    const Vec6 u = least_motion(before, 0, R, axes);
    EXPECT_LE(u.dot(I * u), directions[0].information + 1e-8 * largest);
  }
}

}  // namespace
}  // namespace rali::degeneracy
