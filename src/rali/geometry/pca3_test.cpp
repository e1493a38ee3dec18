#include "rali/geometry/pca3.hpp"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/geometry/robust.hpp"
#include "rali/geometry/so3.hpp"

namespace rali::geometry {
namespace {

TEST(Pca3, orders_eigenvalues_and_returns_a_right_handed_frame) {
  Rng rng(1, "pca");
  for (int k = 0; k < 50; ++k) {
    const Mat3 R = so3_exp(Vec3(rng.normal(), rng.normal(), rng.normal()));
    const Vec3 l(rng.uniform(2.0, 3.0), rng.uniform(1.0, 2.0), rng.uniform(0.0, 1.0));
    const Pca3 p = pca3(R * l.asDiagonal() * R.transpose());
    EXPECT_LT((p.values - l).norm(), 1e-13);
    EXPECT_NEAR(p.vectors.determinant(), 1.0, 1e-13);
    EXPECT_NEAR(std::abs(p.vectors.col(2).dot(R.col(2))), 1.0, 1e-10);
  }
}

TEST(Pca3, keeps_the_thickness_of_a_very_thin_plane) {
  const Mat3 R = so3_exp(Vec3(0.3, -0.5, 1.1));
  const Vec3 l(0.05, 0.04, 1e-14);  // 0.1 micrometre thick
  const Pca3 p = pca3(R * l.asDiagonal() * R.transpose());
  EXPECT_NEAR(p.values[2], 1e-14, 1e-16);
}

TEST(Pca3, of_a_zero_matrix_has_zero_eigenvalues_and_a_valid_frame) {
  const Pca3 p = pca3(Mat3::Zero());
  EXPECT_EQ(p.values, Vec3(Vec3::Zero()));
  EXPECT_NEAR(p.vectors.determinant(), 1.0, 1e-15);
}

TEST(RobustWeights, agree_with_hand_computed_huber_and_cauchy_values) {
  EXPECT_DOUBLE_EQ(huber_weight(0.0, 1.5), 1.0);
  EXPECT_DOUBLE_EQ(huber_weight(-1.5, 1.5), 1.0);
  EXPECT_DOUBLE_EQ(huber_weight(-3.0, 1.5), 0.5);
  EXPECT_DOUBLE_EQ(cauchy_weight(0.0, 3.0), 1.0);
  EXPECT_DOUBLE_EQ(cauchy_weight(-3.0, 3.0), 0.5);
  EXPECT_DOUBLE_EQ(cauchy_weight(9.0, 3.0), 0.1);
}

}  // namespace
}  // namespace rali::geometry
