#include "rali/degeneracy/zhang.hpp"

#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace rali::degeneracy {
namespace {

using geometry::Mat6;
using geometry::Vec3;
using geometry::Vec6;

void add_match(Mat6& H, const Vec3& p, const Vec3& n) {
  Vec6 h;
  h << p.cross(n), n;
  H += h * h.transpose();
}

/// Floor under and walls beside a corridor along x; four points on each, symmetric about the body.
Mat6 corridor() {
  Mat6 H = Mat6::Zero();
  for (const double a : {-2.0, 2.0}) {
    for (const double b : {-1.0, 1.0}) {
      add_match(H, Vec3(a, b, -1.0), Vec3::UnitZ());
      add_match(H, Vec3(a, 1.5, b), Vec3(0.0, -1.0, 0.0));
      add_match(H, Vec3(a, -1.5, b), Vec3::UnitY());
    }
  }
  return H;
}

TEST(ZhangFactors, of_a_corridor_match_hand_computed_values) {
  // h of the floor = (b, -a, 0, 0, 0, 1); of a wall = (-+b, 0, +-a, 0, +-1, 0). Sums of squares:
  // roll 4 + 8, pitch 4 * 4, yaw 8 * 4, y 8, z 4; x and everything mixed 0.
  const ZhangFactors z(corridor());
  Vec6 expected;
  expected << 0.0, 4.0, 8.0, 12.0, 16.0, 32.0;
  EXPECT_LT((z.factors() - expected).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_NEAR(z.translation(), 0.0, 1e-12);
  EXPECT_NEAR(std::abs(z.translation_direction().x()), 1.0, 1e-12);
  EXPECT_EQ(z.degenerate(1.0), 1);
  EXPECT_EQ(z.degenerate(10.0), 3);
}

TEST(ZhangFactors, grow_with_the_point_count_so_no_fixed_threshold_fits) {
  const ZhangFactors once(corridor());
  const ZhangFactors four_times(4.0 * corridor());
  EXPECT_EQ(once.degenerate(10.0), 3);
  EXPECT_EQ(four_times.degenerate(10.0), 1);
}

TEST(ZhangFactors, of_a_nan_matrix_are_zero) {
  Mat6 H = corridor();
  H(2, 4) = std::numeric_limits<double>::quiet_NaN();
  const ZhangFactors z(H);
  EXPECT_EQ(z.factors(), Vec6(Vec6::Zero()));
  EXPECT_EQ(z.degenerate(1e-9), 6);
  EXPECT_TRUE(z.translation_direction().allFinite());
}

}  // namespace
}  // namespace rali::degeneracy
