#include "rali/odometry/mounting.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace rali::odometry {
namespace {

using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;
using geometry::Vec6;

// 0.1 deg at 50 m are 8.7 cm laterally and in height, and nothing along the path.
TEST(Mounting, covariance_is_that_of_rotating_the_path_about_its_start) {
  const SE3 end{geometry::Mat3::Identity(), {50.0, 0.0, 0.0}};
  const Mat6 P = mounting_covariance(SE3{}, end, 0.1 * M_PI / 180.0);
  EXPECT_NEAR(std::sqrt(P(4, 4)), 0.0873, 1e-4);
  EXPECT_NEAR(std::sqrt(P(5, 5)), 0.0873, 1e-4);
  EXPECT_DOUBLE_EQ(P(3, 3), 0.0);
  EXPECT_TRUE((P.topLeftCorner<3, 3>().isZero(0.0))) << "ahead is ahead";
}

// The same by rotating the path: E T E^-1 for a small rotation E about each axis.
TEST(Mounting, covariance_agrees_with_numerically_rotated_lidar_mounting) {
  const SE3 first{geometry::so3_exp(Vec3(0.1, -0.2, 0.7)), {1.0, 2.0, 0.5}};
  const SE3 now{geometry::so3_exp(Vec3(-0.3, 0.4, 2.1)), {-7.0, 11.0, 3.0}};
  constexpr double kTurn = 1e-6;
  Mat6 expected = Mat6::Zero();
  for (int k = 0; k < 3; ++k) {
    const SE3 E{geometry::so3_exp(kTurn * Vec3::Unit(k)), Vec3::Zero()};
    const SE3 taken = first * (E * (first.inverse() * now) * E.inverse());
    const Vec6 off = geometry::boxminus(taken, now) / kTurn;
    expected += off * off.transpose();
  }
  EXPECT_LT((mounting_covariance(first, now, 1.0) - expected).norm(), 1e-4 * expected.norm());
}

}  // namespace
}  // namespace rali::odometry
