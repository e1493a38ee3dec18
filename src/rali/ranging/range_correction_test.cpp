#include "rali/ranging/range_correction.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace rali::ranging {
namespace {

using geometry::Vec3;

/// Anchor at the origin, degenerate along x.
CorrectionInput at(double x, double y, double u, double dz = 0.0) {
  CorrectionInput in;
  in.p_m = Vec3(x, y, dz);
  in.range_m = u;
  in.degenerate = true;
  return in;
}

/// Without any of the limits: the bare equations.
PaperRangeSettings bare() {
  PaperRangeSettings s;
  s.gap_m = 0.0;
  s.max_sensitivity = 1e6;
  return s;
}

// Test T9 of the design, one case after the other.
TEST(RangeCorrection, shifts_along_the_degenerate_direction_onto_the_range_circle) {
  const Correction longer = correct_on_circle(at(20.0, 1.0, 20.5), {});
  EXPECT_EQ(longer.outcome, CorrectionOutcome::kCorrected);
  EXPECT_NEAR(longer.s_m, 0.475595, 1e-6);
  EXPECT_NEAR(longer.gap_m, 0.475016, 1e-6);
  EXPECT_NEAR(longer.sensitivity, 1.0012, 1e-4);
  EXPECT_LT((longer.shift_m - Vec3(0.475595, 0.0, 0.0)).norm(), 1e-6);
  EXPECT_FALSE(longer.closest);
  const Correction shorter = correct_on_circle(at(20.0, 1.0, 19.0), {});
  EXPECT_EQ(shorter.outcome, CorrectionOutcome::kCorrected);
  EXPECT_NEAR(shorter.s_m, -1.026334, 1e-6);
}

TEST(RangeCorrection, can_select_the_root_nearest_to_the_imu_prediction) {
  PaperRangeSettings s = bare();
  s.root = PaperRoot::kNearestImu;
  s.max_s_m = 100.0;
  CorrectionInput in = at(20.0, 1.0, 20.5);
  in.imu_s_m = -39.0;
  EXPECT_NEAR(correct_on_circle(in, s).s_m, -40.4756, 1e-4);
  in.imu_s_m = 0.0;
  EXPECT_NEAR(correct_on_circle(in, s).s_m, 0.475595, 1e-6);
  in.imu_s_m.reset();  // without a prediction there is only the length to choose by
  EXPECT_NEAR(correct_on_circle(in, s).s_m, 0.475595, 1e-6);
}

TEST(RangeCorrection, projects_the_range_by_the_height_difference) {
  const CorrectionInput in = at(20.0, 1.0, 20.5, 1.5);
  EXPECT_NEAR(correct_on_circle(in, {}).s_m, 0.420578, 1e-6);
  PaperRangeSettings s;
  s.range_2d = PaperRange2d::kFlat;
  EXPECT_NEAR(correct_on_circle(in, s).s_m, 0.475595, 1e-6);
  s.range_2d = PaperRange2d::k3d;
  EXPECT_NEAR(correct_on_circle(in, s).s_m, 0.420578, 1e-6);
}

TEST(RangeCorrection, a_range_shorter_than_the_height_difference_is_inconsistent) {
  EXPECT_EQ(correct_on_circle(at(20.0, 1.0, 1.4, 1.5), {}).outcome,
            CorrectionOutcome::kInconsistent);
}

TEST(RangeCorrection, a_range_nearly_perpendicular_to_the_direction_is_too_sensitive) {
  PaperRangeSettings s = bare();
  const Correction out = correct_on_circle(at(2.0, 10.0, 10.1), s);
  EXPECT_NEAR(out.s_m, -0.582255, 1e-6);
  EXPECT_NEAR(out.sensitivity, 7.12, 0.005);
  s.max_sensitivity = 4.0;
  const Correction refused = correct_on_circle(at(2.0, 10.0, 10.1), s);
  EXPECT_EQ(refused.outcome, CorrectionOutcome::kTooSensitive);
  EXPECT_EQ(refused.s_m, 0.0);
  EXPECT_EQ(refused.shift_m, Vec3(Vec3::Zero()));
}

TEST(RangeCorrection, selects_the_root_with_the_smaller_shift) {
  EXPECT_NEAR(correct_on_circle(at(0.3, 10.0, 10.1), bare()).s_m, 1.117745, 1e-6);
  EXPECT_NEAR(correct_on_circle(at(-0.3, 10.0, 10.1), bare()).s_m, -1.117745, 1e-6);
}

TEST(RangeCorrection, an_anchor_abeam_is_ambiguous_without_an_imu_prediction) {
  // Roots -b -+ 1.4177 with b = 0.09 differ in length by 0.18 m, less than two sigmas.
  EXPECT_EQ(correct_on_circle(at(0.09, 10.0, 10.1), bare()).outcome, CorrectionOutcome::kAmbiguous);
  EXPECT_EQ(correct_on_circle(at(0.11, 10.0, 10.1), bare()).outcome, CorrectionOutcome::kCorrected);
  PaperRangeSettings s = bare();
  s.root = PaperRoot::kNearestImu;
  CorrectionInput in = at(0.0, 10.0, 10.1);
  in.imu_s_m = -1.0;  // the prediction decides between them
  EXPECT_NEAR(correct_on_circle(in, s).s_m, -std::sqrt(2.01), 1e-6);
}

TEST(RangeCorrection, a_circle_that_touches_the_line_has_one_solution) {
  PaperRangeSettings s = bare();
  s.max_sensitivity = 4.0;  // infinite there, and not checked
  const Correction out = correct_on_circle(at(0.5, 3.0, 3.0), s);
  EXPECT_EQ(out.outcome, CorrectionOutcome::kCorrected);
  EXPECT_EQ(out.s_m, -0.5);
  EXPECT_TRUE(std::isinf(out.sensitivity));
  EXPECT_TRUE(out.closest);
  s.no_root = PaperNoRoot::kNone;
  EXPECT_EQ(correct_on_circle(at(0.5, 3.0, 3.0), s).s_m, -0.5);
}

TEST(RangeCorrection, a_circle_narrowly_missing_the_line_gives_the_closest_point) {
  PaperRangeSettings s = bare();
  s.gap_m = 0.12;  // gap 0.141 m, miss 0.1 m
  const Correction out = correct_on_circle(at(0.5, 3.0, 2.9), s);
  EXPECT_EQ(out.outcome, CorrectionOutcome::kCorrected);
  EXPECT_EQ(out.s_m, -0.5);
  EXPECT_TRUE(out.closest);
  s.gap_m = 0.09;
  EXPECT_EQ(correct_on_circle(at(0.5, 3.0, 2.9), s).outcome, CorrectionOutcome::kInconsistent);
  s.gap_m = 0.12;
  s.no_root = PaperNoRoot::kNone;
  const Correction none = correct_on_circle(at(0.5, 3.0, 2.9), s);
  EXPECT_EQ(none.outcome, CorrectionOutcome::kInconsistent);
  EXPECT_EQ(none.s_m, 0.0);
}

TEST(RangeCorrection, projects_the_degenerate_direction_onto_the_horizontal_plane) {
  const auto e = horizontal_direction(Vec3(0.95, 0.05, 0.31), 0.5);
  ASSERT_TRUE(e);
  EXPECT_LT((*e - Vec3(0.998618, 0.052559, 0.0)).norm(), 1e-6);
  EXPECT_FALSE(horizontal_direction(Vec3(0.49, 0.0, std::sqrt(1.0 - 0.49 * 0.49)), 0.5));
  EXPECT_TRUE(horizontal_direction(Vec3(0.51, 0.0, std::sqrt(1.0 - 0.51 * 0.51)), 0.5));
  EXPECT_FALSE(horizontal_direction(Vec3::Zero(), 0.5));
  EXPECT_FALSE(horizontal_direction(Vec3(std::nan(""), 1.0, 0.0), 0.5));
}

TEST(RangeCorrection, the_sign_of_the_degenerate_direction_does_not_matter) {
  CorrectionInput in = at(20.0, 1.0, 20.5);
  const Vec3 shift = correct_on_circle(in, {}).shift_m;
  in.e3 = -in.e3;
  EXPECT_LT((correct_on_circle(in, {}).shift_m - shift).norm(), 1e-12);
}

TEST(RangeCorrection, a_vertical_direction_is_refused_in_2d_but_not_in_3d) {
  CorrectionInput in = at(3.0, 0.0, 5.0, 3.0);
  in.e3 = Vec3::UnitZ();
  EXPECT_EQ(correct_on_circle(in, {}).outcome, CorrectionOutcome::kDirectionUnknown);
  PaperRangeSettings s;
  s.range_2d = PaperRange2d::k3d;
  EXPECT_NEAR(correct_on_circle(in, s).shift_m.z(), 1.0, 1e-12);  // 3, 4, 5
  in.e3 = Vec3::Zero();
  EXPECT_EQ(correct_on_circle(in, s).outcome, CorrectionOutcome::kDirectionUnknown);
}

TEST(RangeCorrection, is_not_needed_without_degeneracy_or_below_the_gap) {
  PaperRangeSettings s;
  s.gap_m = 0.3;
  CorrectionInput in = at(20.0, 1.0, 30.0);
  in.degenerate = false;
  EXPECT_EQ(correct_on_circle(in, {}).outcome, CorrectionOutcome::kNotNeeded);
  EXPECT_EQ(correct_on_circle(at(20.0, 0.0, 20.29), s).outcome, CorrectionOutcome::kNotNeeded);
  EXPECT_EQ(correct_on_circle(at(20.0, 0.0, 20.31), s).outcome, CorrectionOutcome::kCorrected);
}

TEST(RangeCorrection, a_correction_longer_than_5_m_is_refused) {
  PaperRangeSettings s;
  s.max_s_m = 5.0;
  EXPECT_EQ(correct_on_circle(at(20.0, 0.0, 25.1), s).outcome, CorrectionOutcome::kTooFar);
  EXPECT_EQ(correct_on_circle(at(20.0, 0.0, 24.9), s).outcome, CorrectionOutcome::kCorrected);
}

TEST(RangeCorrection, invalid_numbers_are_inconsistent_and_shift_nothing) {
  const double nan = std::nan("");
  for (const CorrectionInput& in : {at(nan, 0.0, 20.0), at(20.0, 0.0, nan), at(20.0, 0.0, 0.0),
                                    at(20.0, 0.0, -5.0), at(20.0, 1e308 * 10.0, 5.0)}) {
    const Correction out = correct_on_circle(in, {});
    EXPECT_EQ(out.outcome, CorrectionOutcome::kInconsistent);
    EXPECT_EQ(out.s_m, 0.0);
  }
}

TEST(RangeCorrection, an_anchor_at_the_same_position_is_ambiguous) {
  EXPECT_EQ(correct_on_circle(at(0.0, 0.0, 2.0), {}).outcome, CorrectionOutcome::kAmbiguous);
}

void expect_fractions(const std::vector<double>& got, std::initializer_list<double> expected) {
  ASSERT_EQ(got.size(), expected.size());
  std::size_t i = 0;
  for (const double e : expected) EXPECT_NEAR(got[i++], e, 1e-6);
}

// Test T10 of the design.
TEST(RangeCorrection, distributes_a_shift_in_proportion_to_the_odometry_variance) {
  const std::vector<double> increments{0.01, 0.01, 0.04, 0.01, 0.03};
  expect_fractions(share_shift(increments, 0.5), {0.05, 0.10, 0.30, 0.35, 0.50});
}

TEST(RangeCorrection, does_not_shift_steps_with_zero_odometry_variance) {
  expect_fractions(share_shift(std::vector<double>{0.0, 0.01, 0.0}, 0.5), {0.0, 0.5, 0.5});
  expect_fractions(share_shift(std::vector<double>{0.0, 0.0}, 0.5), {0.0, 0.0});
  EXPECT_TRUE(share_shift({}, 0.5).empty());
}

}  // namespace
}  // namespace rali::ranging
