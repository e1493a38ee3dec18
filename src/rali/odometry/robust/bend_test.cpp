#include "rali/odometry/robust/bend.hpp"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace rali::odometry {
namespace {

using geometry::Mat6;
using geometry::Vec3;
using geometry::Vec6;

constexpr double kBend_radpm = 1.0 / 300.0;  // to the left, driving along x

/// Drives along x at 2 m/s, with a position sigma of a metre along x.
FilterState driving() {
  FilterState state;
  state.v = Vec3(2.0, 0.0, 0.0);
  state.P.diagonal().setConstant(1e-8);
  state.P(kPos, kPos) = 1.0;
  return state;
}

Bend bent(double radpm = kBend_radpm) {
  Bend bend;
  for (int k = 1; k <= 50; ++k) bend.follow(Vec3::UnitX(), radpm, 0.02 * k);
  return bend;
}

/// A scan at the origin between two walls 3 m to either side, bent by `radpm` per metre.
Mat6 scan_of_bent_walls(double radpm) {
  Mat6 I = Mat6::Zero();
  const Vec3 centre(0.0, 1.0 / radpm, 0.0);
  for (const double side : {-3.0, 3.0}) {
    for (double along_m = -20.0; along_m <= 20.0; along_m += 0.5) {
      const double angle = along_m * radpm;
      const Vec3 inward(-std::sin(angle), std::cos(angle), 0.0);
      const Vec3 point = centre - (1.0 / radpm - side) * inward;
      Vec6 row;
      row << point.cross(inward), inward;
      I += 1e4 * row * row.transpose();
    }
  }
  I.diagonal().head<2>().array() += 1e6;  // the floor
  I(5, 5) += 1e6;
  return I;
}

TEST(Bend, changes_sign_when_the_axis_is_reversed) {
  Bend bend = bent();
  EXPECT_NEAR(bend.here_radpm(), kBend_radpm, 1e-12);
  bend.follow(-Vec3::UnitX(), -kBend_radpm, 1.0);
  EXPECT_NEAR(bend.here_radpm(), -kBend_radpm, 1e-12);
  EXPECT_NEAR(bend.gathered_radpm(), -kBend_radpm, 1e-12);
}

TEST(Bend, averages_the_noise_of_single_scans) {
  Bend bend;
  for (int k = 0; k < 200; ++k) bend.follow(Vec3::UnitX(), k % 2 == 0 ? 1e-3 : -1e-3, 1.0);
  EXPECT_LT(std::abs(bend.here_radpm()), 5e-5);
}

TEST(Bend, weights_curvature_by_the_uncertainty_gained_in_each_bend) {
  Bend bend;
  for (int k = 1; k <= 400; ++k) bend.follow(Vec3::UnitX(), 0.004, 1.0 * k / 400);
  for (int k = 1; k <= 400; ++k) bend.follow(Vec3::UnitX(), 0.0, 1.0 + 1.0 * k / 400);
  // The first metre of sigma has a bend of 4 mrad, the second has none (except the lag of the
  // mean).
  EXPECT_NEAR(bend.gathered_radpm() * 2.0, 0.004, 3e-4);
  EXPECT_LT(bend.here_radpm(), 1e-6);
}

TEST(Bend, a_position_correction_follows_the_arc_and_keeps_heading_tangential) {
  const Bend bend = bent();
  FilterState state = driving();
  StateVec delta = StateVec::Zero();
  delta[kPos] = 60.0;
  bend.move(state, delta);
  const Vec3 centre(0.0, 300.0, 0.0);
  EXPECT_NEAR((state.T_odom_body.p - centre).norm(), 300.0, 1e-9);
  const Vec3 heading = state.T_odom_body.R.col(0);
  EXPECT_NEAR(heading.dot((state.T_odom_body.p - centre).normalized()), 0.0, 1e-9);
  EXPECT_NEAR((state.v - 2.0 * heading).norm(), 0.0, 1e-9);
  EXPECT_NEAR(std::atan2(heading.y(), heading.x()), 0.2, 1e-9);
}

TEST(Bend, a_speed_correction_adjusts_the_gyro_bias_by_the_curvature) {
  FilterState state = driving();
  StateVec delta = StateVec::Zero();
  delta[kVel] = 0.3;
  bent().move(state, delta);
  // Measured rate minus bias is what the bend gives for the speed.
  EXPECT_NEAR(state.gyro_bias_radps.z(), -0.3 * kBend_radpm, 1e-12);
}

TEST(Bend, unobservable_motion_of_a_scan_is_a_screw) {
  const Bend bend = bent();
  const FilterState state = driving();
  const Mat6 I = bend.unseen_in(scan_of_bent_walls(kBend_radpm), state);
  Vec6 screw;
  screw << 0.0, 0.0, kBend_radpm, 1.0, 0.0, 0.0;
  EXPECT_LT((I * screw).norm(), 1e-9 * I.norm());
  Vec6 shift = Vec6::Zero();
  shift[3] = 1.0;
  EXPECT_GT(shift.dot(I * shift), 1.0);
}

TEST(Bend, position_uncertainty_along_a_bend_implies_heading_uncertainty) {
  const Mat6 P = bent().turned_covariance(driving());
  EXPECT_NEAR(std::sqrt(P(2, 2)), kBend_radpm, 1e-9);
  EXPECT_NEAR(P(2, 3), kBend_radpm, 1e-9);
  EXPECT_NEAR(P(3, 3), 0.0, 1e-12);  // already in the filter's covariance
  EXPECT_NEAR(std::sqrt(P(4, 4)), 0.5 * kBend_radpm, 1e-9) << "an arc ends beside its tangent";
}

TEST(Bend, has_no_effect_after_the_degenerate_stretch_ends) {
  Bend bend = bent();
  bend.end();
  FilterState state = driving();
  EXPECT_TRUE(bend.jacobian(state).isIdentity(0.0));
  EXPECT_TRUE(bend.turned_covariance(state).isZero(0.0));
  StateVec delta = StateVec::Zero();
  delta[kPos] = 60.0;
  bend.move(state, delta);
  EXPECT_EQ(state.T_odom_body.p, Vec3(60.0, 0.0, 0.0));
}

}  // namespace
}  // namespace rali::odometry
