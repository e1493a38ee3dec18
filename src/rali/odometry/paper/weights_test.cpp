#include "rali/odometry/paper/weights.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "rali/geometry/so3.hpp"

namespace rali::odometry::paper {
namespace {

using geometry::Vec3;

constexpr double kDeg = std::numbers::pi / 180.0;
const RangeQuartiles kQuartiles{4.0, 6.0};

// 10 m along x, the normal 60 deg from the ray (test T6 of the design).
const Vec3 kPoint(10.0, 0.0, 0.0);
const Vec3 kNormal(0.5, std::sqrt(0.75), 0.0);

TEST(PaperWeights, agree_with_the_numbers_worked_by_hand) {
  const PaperSettings s;
  EXPECT_NEAR(range_weight(10.0, kQuartiles), 0.924142, 1e-6);
  EXPECT_NEAR(neighbour_weight(6, 8), 0.75, 1e-15);
  EXPECT_NEAR(kinematic_weight(kPoint, kNormal, kQuartiles, s), 10.47198, 1e-5);
  EXPECT_NEAR(multi_metric_weight(kPoint, kNormal, 6, false, kQuartiles, s), 0.612071, 1e-6);
  EXPECT_NEAR(multi_metric_weight(kPoint, kNormal, 6, true, kQuartiles, s), 3.753664, 1e-6);
}

TEST(PaperWeights, kinematic_weight_with_quartile_scale_is_independent_of_length_units) {
  PaperSettings s;
  s.kin_scale = KinematicScale::kQuartile;
  EXPECT_NEAR(kinematic_weight(kPoint, kNormal, kQuartiles, s), 1.745329, 1e-6);
  EXPECT_NEAR(multi_metric_weight(kPoint, kNormal, 6, true, kQuartiles, s), 1.135670, 1e-6);
  EXPECT_NEAR(multi_metric_weight(100.0 * kPoint, kNormal, 6, true, {400.0, 600.0}, s), 1.135670,
              1e-6);
  s.kin_scale = KinematicScale::kNone;
  EXPECT_NEAR(kinematic_weight(kPoint, kNormal, kQuartiles, s), 60.0 * kDeg, 1e-12);
}

TEST(PaperWeights, rotation_angle_as_printed_is_half_the_angle) {
  const geometry::Mat3 R = geometry::so3_exp(10.0 * kDeg * Vec3(0.6, 0.0, 0.8));
  EXPECT_NEAR(rotation_angle_rad(R, RotationAngle::kHalf), 5.0 * kDeg, 1e-12);
  EXPECT_NEAR(rotation_angle_rad(R, RotationAngle::kFull), 10.0 * kDeg, 1e-12);
}

TEST(PaperWeights, raw_point_clamps_the_argument_instead_of_giving_nan) {
  PaperSettings s;
  s.kin_point = KinematicPoint::kRaw;
  // <p, n> = 5 has no arc cosine. Clamped to 1 the angle is 0.
  EXPECT_EQ(kinematic_weight(kPoint, kNormal, kQuartiles, s), 0.0);
  s.kin_abs = false;
  EXPECT_NEAR(kinematic_weight(kPoint, -kNormal, kQuartiles, s), std::numbers::pi * 10.0, 1e-9);
}

TEST(PaperWeights, ignore_the_sign_of_the_normal_unless_set_as_printed) {
  PaperSettings s;
  EXPECT_EQ(kinematic_weight(kPoint, kNormal, kQuartiles, s),
            kinematic_weight(kPoint, -kNormal, kQuartiles, s));
  s.kin_abs = false;
  EXPECT_NEAR(kinematic_weight(kPoint, -kNormal, kQuartiles, s), 120.0 * kDeg * 10.0, 1e-9);
}

TEST(PaperWeights, stay_finite_at_extreme_inputs) {
  const PaperSettings s;
  EXPECT_EQ(range_weight(0.0, {0.0, 0.0}), 1.0);
  EXPECT_NEAR(range_weight(4.0, kQuartiles), 0.5, 1e-15);
  EXPECT_NEAR(range_weight(1e9, kQuartiles), 1.0, 1e-15);
  EXPECT_EQ(neighbour_weight(0, 8), 0.0);
  EXPECT_EQ(neighbour_weight(8, 8), 1.0);
  EXPECT_EQ(neighbour_weight(1000, 8), 1.0);
  EXPECT_EQ(kinematic_weight(Vec3::Zero(), kNormal, kQuartiles, s), 0.0);
  PaperSettings quartile;
  quartile.kin_scale = KinematicScale::kQuartile;
  EXPECT_TRUE(std::isfinite(kinematic_weight(kPoint, kNormal, {0.0, 0.0}, quartile)));
}

TEST(PaperWeights, quartiles_are_nearest_ranks) {
  std::vector<double> four{4.0, 1.0, 3.0, 2.0};
  EXPECT_EQ(range_quartiles(four).q2_m, 2.0);
  EXPECT_EQ(range_quartiles(four).q3_m, 3.0);
  std::vector<double> one{7.0};
  EXPECT_EQ(range_quartiles(one).q2_m, 7.0);
  EXPECT_EQ(range_quartiles(one).q3_m, 7.0);
  std::vector<double> none;
  EXPECT_EQ(range_quartiles(none).q3_m, 0.0);
}

// Finding F9: inside rho the information grows with the square of the weight and the knee moves.
TEST(PaperWeights, weight_inside_rho_is_squared_and_shifts_the_huber_threshold) {
  PaperSettings s;
  s.huber_m = 0.1;
  EXPECT_NEAR(irls_weight(0.5, 0.19, s), 0.25, 1e-15);
  EXPECT_NEAR(irls_weight(0.5, 0.4, s), 0.25 * 0.1 / 0.2, 1e-15);
  EXPECT_NEAR(irls_weight(4.0, 0.05, s), 16.0 * 0.1 / 0.2, 1e-12);
  s.weight_place = WeightPlace::kOutside;
  EXPECT_NEAR(irls_weight(0.5, 0.19, s), 0.5 * 0.1 / 0.19, 1e-15);
  EXPECT_NEAR(irls_weight(4.0, 0.05, s), 4.0, 1e-15);
}

// The weight must be rho'(r)/r; otherwise the steps do not descend the cost that accepts them.
TEST(PaperWeights, irls_weight_times_residual_is_the_slope_of_the_cost) {
  for (const WeightPlace place : {WeightPlace::kInside, WeightPlace::kOutside}) {
    PaperSettings s;
    s.weight_place = place;
    for (const double omega : {0.5, 1.0, 4.0}) {
      for (const double r : {-0.5, -0.02, 0.03, 0.3}) {
        const double h = 1e-6;
        const double slope =
            (robust_cost(omega, r + h, s) - robust_cost(omega, r - h, s)) / (2 * h);
        EXPECT_NEAR(irls_weight(omega, r, s) * r, slope, 1e-8);
      }
    }
  }
}

TEST(PaperWeights, literal_setting_selects_the_formulas_as_printed) {
  PaperSettings s;
  s.literal = true;
  const PaperSettings r = s.resolved();
  EXPECT_EQ(r.kin_point, KinematicPoint::kRaw);
  EXPECT_EQ(r.rot_angle, RotationAngle::kHalf);
  EXPECT_FALSE(r.kin_abs);
  EXPECT_EQ(r.kin_scale, KinematicScale::kMetre);
  EXPECT_EQ(PaperSettings{}.resolved().kin_point, KinematicPoint::kUnit);
}

}  // namespace
}  // namespace rali::odometry::paper
