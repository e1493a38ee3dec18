#include <cmath>
#include <numbers>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "rali/eval/alignment.hpp"
#include "rali/eval/consistency.hpp"
#include "rali/eval/errors.hpp"

namespace rali::eval {
namespace {

using geometry::Mat3;
using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;

constexpr double kDegree = std::numbers::pi / 180.0;

SE3 pose(double x, double y, double z, double yaw_deg = 0.0) {
  return {geometry::rotation_from_rpy(0.0, 0.0, yaw_deg * kDegree), Vec3(x, y, z)};
}

PosePair pair_of(int i, const SE3& est, const SE3& ref) {
  return {Time::from_ns(i), est, ref, static_cast<std::size_t>(i)};
}

/// Unit square as reference; the estimate is rotated by 90 deg, shifted, one corner 0.2 m too high.
PairList square() {
  const Mat3 R = geometry::rotation_from_rpy(0.0, 0.0, 90.0 * kDegree);
  const std::array<Vec3, 4> corners{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(0, 1, 0)};
  PairList pairs;
  for (int i = 0; i < 4; ++i) {
    const Vec3& c = corners[static_cast<std::size_t>(i)];
    const Vec3 bump(0.0, 0.0, i == 3 ? 0.2 : 0.0);
    pairs.push_back(pair_of(i, {R, R * c + Vec3(5, 2, 0) + bump}, {Mat3::Identity(), c}));
  }
  return pairs;
}

TEST(Alignment, of_a_square_with_a_raised_corner_matches_hand_computed_errors) {
  const PairList pairs = square();
  const auto T = align(pairs, Alignment::kSe3);
  ASSERT_TRUE(T.has_value());
  const auto errors = absolute_errors(pairs, *T);
  EXPECT_NEAR(errors[0].translation_m, 0.0500, 5e-5);
  EXPECT_NEAR(errors[1].translation_m, 0.0495, 5e-5);
  EXPECT_NEAR(errors[2].translation_m, 0.0500, 5e-5);
  EXPECT_NEAR(errors[3].translation_m, 0.0515, 5e-5);
  const Statistics s = translation_statistics(errors);
  EXPECT_NEAR(s.mean, 0.050242, 1e-6);
  EXPECT_NEAR(s.rmse, 0.050247, 1e-6);
  EXPECT_NEAR(s.max, 0.051459, 1e-6);
}

TEST(Alignment, yaw_alignment_keeps_the_vertical) {
  const PairList pairs = square();
  const auto T = align(pairs, Alignment::kYaw);
  ASSERT_TRUE(T.has_value());
  EXPECT_NEAR(geometry::rpy_from_rotation(T->R).z(), -90.0 * kDegree, 1e-12);
  const std::vector<double> z = axis_errors(pairs, *T, Vec3::UnitZ());
  EXPECT_NEAR(z[0], -0.05, 1e-12);
  EXPECT_NEAR(z[3], 0.15, 1e-12);
}

TEST(Alignment, origin_alignment_makes_the_first_poses_coincide) {
  const PairList pairs = square();
  const auto T = align(pairs, Alignment::kOrigin);
  ASSERT_TRUE(T.has_value());
  const auto errors = absolute_errors(pairs, *T);
  EXPECT_NEAR(errors[0].translation_m, 0.0, 1e-12);
  EXPECT_NEAR(errors[3].translation_m, 0.2, 1e-12);
}

TEST(Alignment, mirror_images_are_not_aligned_by_a_reflection) {
  PairList pairs = square();
  for (PosePair& p : pairs) p.est.p.x() = -p.est.p.x();
  const auto T = align(pairs, Alignment::kSe3);
  ASSERT_TRUE(T.has_value());
  EXPECT_NEAR(T->R.determinant(), 1.0, 1e-12);
}

TEST(Alignment, positions_on_a_line_are_refused_for_se3) {
  PairList pairs;
  for (int i = 0; i < 5; ++i) pairs.push_back(pair_of(i, pose(i, 0, 0), pose(i, 0, 0)));
  const auto T = align(pairs, Alignment::kSe3);
  ASSERT_FALSE(T.has_value());
  EXPECT_EQ(T.error().code, ErrorCode::kNoAnswer);
  EXPECT_TRUE(align(pairs, Alignment::kYaw).has_value());
}

TEST(Alignment, one_fleet_transform_reveals_a_shift_that_separate_ones_hide) {
  // Two perfect lines 4 m apart; the second vehicle's estimate is shifted by 0.6 m laterally.
  PairList first;
  PairList second;
  for (int i = 0; i < 4; ++i) {
    first.push_back(pair_of(i, pose(i, 0, 0), pose(i, 0, 0)));
    second.push_back(pair_of(i, pose(i, 4.6, 0), pose(i, 4, 0)));
  }
  PairList fleet = first;
  fleet.insert(fleet.end(), second.begin(), second.end());
  const auto alone = align(second, Alignment::kYaw);
  const auto together = align(fleet, Alignment::kSe3);
  ASSERT_TRUE(alone && together);
  EXPECT_NEAR(translation_statistics(absolute_errors(second, *alone)).rmse, 0.0, 1e-12);
  EXPECT_NEAR(translation_statistics(absolute_errors(fleet, *together)).rmse, 0.300, 1e-9);
}

TEST(RelativeErrors, report_a_step_of_two_percent_and_two_degrees_once) {
  PairList pairs;
  SE3 est = pose(0, 0, 0);
  for (int i = 0; i < 4; ++i) {
    pairs.push_back(pair_of(i, est, pose(i, 0, 0)));
    est = est * (i == 0 ? pose(1.02, 0, 0, 2.0) : pose(1, 0, 0));
  }
  const auto errors = relative_errors(pairs, {1.0, true, 0.1});
  ASSERT_EQ(errors.size(), 3U);
  EXPECT_NEAR(errors[0].translation_m, 0.02, 1e-12);
  EXPECT_NEAR(errors[0].rotation_rad / kDegree, 2.0, 1e-9);
  EXPECT_NEAR(errors[1].translation_m, 0.0, 1e-12);
  EXPECT_NEAR(errors[2].rotation_rad, 0.0, 1e-9);
}

TEST(RelativeErrors, consecutive_segments_do_not_overlap_and_short_paths_give_none) {
  PairList pairs;
  for (int i = 0; i <= 20; ++i)
    pairs.push_back(pair_of(i, pose(0.5 * i, 0, 0), pose(0.5 * i, 0, 0)));
  // As in evo the first piece starts at the end of the first two metres.
  EXPECT_EQ(relative_errors(pairs, {2.0, false, 0.1}).size(), 4U);
  EXPECT_EQ(relative_errors(pairs, {2.0, true, 0.1}).size(), 17U);
  EXPECT_TRUE(relative_errors(pairs, {50.0, true, 0.1}).empty());
  EXPECT_TRUE(relative_errors({}, {1.0, true, 0.1}).empty());
}

TEST(RelativeErrors, standstill_adds_no_distance_travelled) {
  PairList pairs;
  for (int i = 0; i < 10; ++i) pairs.push_back(pair_of(i, pose(0, 0, 0), pose(0, 0, 0)));
  pairs.push_back(pair_of(10, pose(1, 0, 0), pose(1, 0, 0)));
  EXPECT_EQ(relative_errors(pairs, {1.0, true, 0.1}).size(), 10U);
}

TEST(AlongPath, error_is_negative_when_the_estimate_lags_behind) {
  PairList pairs;
  for (int i = 0; i <= 10; ++i) {
    pairs.push_back(pair_of(i, pose(0.0, 0.9 * i, 0.0), pose(0.0, i, 0.0)));
  }
  const std::vector<double> e = along_path_errors(pairs, SE3{}, 2.0);
  EXPECT_EQ(e[1], 0.0);
  EXPECT_NEAR(e[10], -1.0, 1e-12);
}

TEST(Statistics, of_four_numbers_match_hand_computed_values) {
  const Statistics s = statistics({1.0, 4.0, 2.0, 3.0});
  EXPECT_DOUBLE_EQ(s.mean, 2.5);
  EXPECT_DOUBLE_EQ(s.median, 2.5);
  EXPECT_DOUBLE_EQ(s.sse, 30.0);
  EXPECT_NEAR(s.rmse, std::sqrt(7.5), 1e-15);
  EXPECT_NEAR(s.std, std::sqrt(1.25), 1e-15);
  EXPECT_DOUBLE_EQ(s.min, 1.0);
  EXPECT_DOUBLE_EQ(s.max, 4.0);
  EXPECT_EQ(statistics({}).count, 0U);
  EXPECT_DOUBLE_EQ(quantile({0.0, 10.0}, 0.99), 9.9);
}

TEST(Statistics, chi_square_quantiles_are_those_of_printed_tables) {
  EXPECT_NEAR(chi2_quantile(0.99, 1), 6.635, 5e-4);
  EXPECT_NEAR(chi2_quantile(0.999, 3), 16.266, 5e-4);
  EXPECT_NEAR(chi2_quantile(0.999, 6), 22.458, 5e-4);
  EXPECT_NEAR(nees_bounds(50, 3).low, 2.360, 5e-4);
  EXPECT_NEAR(nees_bounds(50, 3).high, 3.716, 5e-4);
  EXPECT_NEAR(nees_bounds(100, 6).low, 5.340, 5e-4);
  EXPECT_NEAR(nees_bounds(100, 6).high, 6.698, 5e-4);
}

TEST(Consistency, nees_of_one_sigma_errors_equals_the_dimension) {
  const SE3 est = pose(1, 2, 3, 40.0);
  Mat6 P = Mat6::Zero();
  P.diagonal() << 1e-4, 4e-4, 9e-4, 0.01, 0.04, 0.09;
  geometry::Vec6 sigma;
  sigma << 0.01, 0.02, 0.03, 0.1, 0.2, 0.3;
  const SE3 truth = geometry::boxplus(est, sigma);
  EXPECT_NEAR(nees_pose(est, truth, P).value(), 6.0, 1e-9);
  EXPECT_NEAR(nees_position(est, truth, P).value(), 3.0, 1e-9);
}

TEST(Consistency, invalid_covariances_are_counted_but_not_used) {
  const PairList pairs{pair_of(0, pose(0, 0, 0), pose(0, 0, 0)),
                       pair_of(1, pose(1, 0, 0), pose(1, 0, 0)),
                       pair_of(2, pose(2, 0, 0), pose(2.1, 0, 0))};
  Mat6 nan = Mat6::Identity();
  nan(2, 2) = std::nan("");
  const Consistency c =
      consistency(pairs, {Mat6::Zero(), nan, 0.0025 * Mat6::Identity()}, SE3{}, 6);
  EXPECT_EQ(c.used, 1U);
  EXPECT_EQ(c.unusable, 2U);
  EXPECT_NEAR(c.mean, 4.0, 1e-9);
  EXPECT_EQ(c.fraction_within_95, 1.0);
}

TEST(Association, pairs_the_nearest_pose_within_10_ms) {
  const PoseList ref{{Time::from_s(1.0), pose(1, 0, 0)}, {Time::from_s(2.0), pose(2, 0, 0)}};
  const PoseList est{{Time::from_s(0.995), pose(0, 0, 0)},
                     {Time::from_s(1.5), pose(0, 0, 0)},
                     {Time::from_s(2.011), pose(0, 0, 0)}};
  const auto a = associate(est, ref, {});
  ASSERT_TRUE(a.has_value());
  ASSERT_EQ(a->pairs.size(), 1U);
  EXPECT_EQ(a->pairs[0].ref.p.x(), 1.0);
  // As in evo, pairing starts from the shorter list: one of the two references has no estimate.
  EXPECT_EQ(a->unmatched, 1U);
}

TEST(Association, does_not_interpolate_across_gaps_or_beyond_ends) {
  const PoseList ref{{Time::from_s(1.0), pose(1, 0, 0)},
                     {Time::from_s(1.2), pose(2, 0, 0, 20.0)},
                     {Time::from_s(3.0), pose(3, 0, 0)}};
  const PoseList est{{Time::from_s(0.9), pose(0, 0, 0)},
                     {Time::from_s(1.05), pose(0, 0, 0)},
                     {Time::from_s(2.0), pose(0, 0, 0)},
                     {Time::from_s(3.0), pose(0, 0, 0)}};
  const auto a = associate(est, ref, {AssociationMode::kInterpolate, 0.01, 0.25});
  ASSERT_TRUE(a.has_value());
  ASSERT_EQ(a->pairs.size(), 2U);
  EXPECT_NEAR(a->pairs[0].ref.p.x(), 1.25, 1e-9);
  EXPECT_NEAR(geometry::rpy_from_rotation(a->pairs[0].ref.R).z() / kDegree, 5.0, 1e-6);
  EXPECT_EQ(a->pairs[1].est_index, 3U);
}

TEST(Association, refuses_unsorted_times_and_non_overlapping_clocks) {
  const PoseList good{{Time::from_s(1.0), pose(1, 0, 0)}, {Time::from_s(2.0), pose(2, 0, 0)}};
  const PoseList twice{{Time::from_s(1.0), pose(1, 0, 0)}, {Time::from_s(1.0), pose(2, 0, 0)}};
  const PoseList later{{Time::from_s(100.0), pose(1, 0, 0)}};
  EXPECT_EQ(associate(good, twice, {}).error().code, ErrorCode::kInput);
  EXPECT_EQ(associate(good, later, {}).error().code, ErrorCode::kNoAnswer);
  EXPECT_EQ(associate(good, {}, {}).error().code, ErrorCode::kNoAnswer);
  EXPECT_EQ(associate({}, good, {}).error().code, ErrorCode::kNoAnswer);
}

}  // namespace
}  // namespace rali::eval
