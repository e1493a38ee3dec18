#include "rali/odometry/robust/coarse_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "rali/odometry/robust/wide_search.hpp"
#include "rali/odometry/room_for_test.hpp"

namespace rali::odometry {
namespace {

using geometry::SE3;
using geometry::Vec3;

constexpr double kDegree = std::numbers::pi / 180.0;
const Vec3 kUp = Vec3::UnitZ();

/// Points of the room from a pose, in the body frame (no motion within the scan).
BodyPoints seen_from(const TestRoom& room, const SE3& T_room_body, int step_deg) {
  BodyPoints out;
  for (int azimuth = 0; azimuth < 360; azimuth += step_deg) {
    for (int elevation = -40; elevation <= 40; elevation += step_deg) {
      const double a = azimuth * kDegree;
      const double e = elevation * kDegree;
      const Vec3 ray(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e));
      const Vec3 p = room.range_to(T_room_body.p, T_room_body.R * ray) * ray;
      out.x_m.push_back(static_cast<float>(p.x()));
      out.y_m.push_back(static_cast<float>(p.y()));
      out.z_m.push_back(static_cast<float>(p.z()));
      out.age_s.push_back(0.0F);
    }
  }
  return out;
}

/// The first scan is taken at the origin, the second after a rotation and a step.
struct CoarseSearchTest : testing::Test {
  CoarseSearchTest() {
    recent.add(seen_from(room, SE3{}, 2), SE3{});
    truth.R = geometry::rotation_from_rpy(0.0, 0.0, 45.0 * kDegree);
    truth.p = Vec3(0.5, -0.33, 0.0);  // 0.6 m
    now = seen_from(room, truth, 3);
  }

  [[nodiscard]] double turn_deg(const SE3& T) const {
    return geometry::so3_log(truth.R.transpose() * T.R).norm() / kDegree;
  }

  TestRoom room;
  RecentPoints recent;
  SE3 truth;
  BodyPoints now;
  CoarseSearchSettings settings;
};

TEST(PoseGuess, excludes_uncertainty_along_degenerate_translations_and_the_correlated_rotation) {
  // 50 m along x with 0.01 rad per metre, plus independent 0.02 rad and 0.1 m laterally.
  geometry::Mat6 P = geometry::Mat6::Zero();
  geometry::Vec6 slide = geometry::Vec6::Zero();
  slide[3] = 50.0;
  slide[2] = 0.5;
  P += slide * slide.transpose();
  P(2, 2) += 0.02 * 0.02;
  P(4, 4) += 0.1 * 0.1;
  const PoseGuess all = guess_from(SE3{}, P, {}, kUp);
  EXPECT_NEAR(all.sigma_m, 50.0, 1e-9);
  EXPECT_NEAR(all.sigma_rad, std::hypot(0.5, 0.02), 1e-9);
  const PoseGuess rest = guess_from(SE3{}, P, std::array{Vec3(Vec3::UnitX())}, kUp);
  EXPECT_NEAR(rest.sigma_m, 0.1, 1e-9);
  EXPECT_NEAR(rest.sigma_rad, 0.02, 1e-6);
  EXPECT_TRUE(needs_search(all, {}));
  EXPECT_FALSE(needs_search(rest, {}));
}

TEST_F(CoarseSearchTest, finds_a_rotation_of_45_degrees_and_a_step_of_60_cm) {
  const PoseGuess guess{SE3{}, 0.3, 15.0 * kDegree};
  const auto found = search_pose(recent, now, guess, kUp, settings);
  ASSERT_FALSE(found.empty());
  EXPECT_LT((found.front().p - truth.p).norm(), 0.15);
  EXPECT_LT(turn_deg(found.front()), 3.0);
}

TEST_F(CoarseSearchTest, returns_a_correct_guess_first) {
  const PoseGuess guess{truth, 0.3, 15.0 * kDegree};
  const auto found = search_pose(recent, now, guess, kUp, settings);
  ASSERT_FALSE(found.empty());
  EXPECT_LT((found.front().p - truth.p).norm(), 0.10);
  EXPECT_LT(turn_deg(found.front()), 2.0);
}

TEST_F(CoarseSearchTest, refines_a_small_tilt_and_a_rise_of_12_cm) {
  truth.R = geometry::rotation_from_rpy(0.05, -0.04, 30.0 * kDegree);
  truth.p = Vec3(0.3, 0.4, 0.12);
  now = seen_from(room, truth, 3);
  const PoseGuess guess{SE3{}, 0.3, 15.0 * kDegree};
  const auto found = search_pose(recent, now, guess, kUp, settings);
  ASSERT_FALSE(found.empty());
  EXPECT_LT((found.front().p - truth.p).norm(), 0.15);
  EXPECT_LT(turn_deg(found.front()), 3.0);
}

TEST_F(CoarseSearchTest, two_places_that_look_alike_are_both_returned) {
  const Vec3 apart(20.0, 0.0, 0.0);
  BodyPoints copy = seen_from(room, SE3{}, 2);
  recent.add(copy, SE3{geometry::Mat3::Identity(), apart});
  settings.range_max_m = 14.0;
  const PoseGuess guess{SE3{geometry::Mat3::Identity(), 0.5 * apart}, 14.0, 30.0 * kDegree};
  const auto found = search_places(recent, now, guess, kUp, settings, 1.0, 12);
  const auto has = [&](const Vec3& p) {
    return std::any_of(found.begin(), found.end(),
                       [&](const SE3& T) { return (T.p - p).norm() < 0.3 && turn_deg(T) < 6.0; });
  };
  EXPECT_TRUE(has(truth.p));
  EXPECT_TRUE(has(truth.p + apart));
}

TEST_F(CoarseSearchTest, stays_near_the_configured_search_range) {
  settings.range_max_m = 0.2;
  settings.range_max_deg = 10.0;
  const PoseGuess guess{SE3{}, 0.3, 15.0 * kDegree};
  for (const SE3& T : search_pose(recent, now, guess, kUp, settings)) {
    // One step of the grid and of the refinement may exceed the range.
    EXPECT_LT(geometry::so3_log(T.R).norm(), 20.0 * kDegree);
    EXPECT_LT(T.p.norm(), 1.2);
  }
}

TEST_F(CoarseSearchTest, merges_refinements_that_converge_to_one_pose) {
  const PoseGuess guess{SE3{}, 0.3, 15.0 * kDegree};
  const auto found = search_pose(recent, now, guess, kUp, settings);
  ASSERT_FALSE(found.empty());
  ASSERT_LE(found.size(), 3U);
  for (std::size_t i = 0; i < found.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const bool turned =
          geometry::so3_log(found[i].R.transpose() * found[k].R).norm() > 1.0 * kDegree;
      EXPECT_TRUE(turned || (found[i].p - found[k].p).norm() > 0.05);
    }
  }
}

TEST_F(CoarseSearchTest, returns_nothing_with_too_few_points) {
  now.resize(40);
  EXPECT_TRUE(search_pose(recent, now, {SE3{}, 0.3, 0.2}, kUp, settings).empty());
}

TEST_F(CoarseSearchTest, ignores_non_finite_points) {
  for (std::size_t i = 0; i < now.size(); i += 7) {
    now.x_m[i] = std::numeric_limits<float>::quiet_NaN();
    now.y_m[i] = std::numeric_limits<float>::infinity();
  }
  recent.add(now, truth);
  const auto found = search_pose(recent, now, {SE3{}, 0.3, 15.0 * kDegree}, kUp, settings);
  ASSERT_FALSE(found.empty());
  EXPECT_TRUE(found.front().p.allFinite());
  EXPECT_LT((found.front().p - truth.p).norm(), 0.2);
}

TEST_F(CoarseSearchTest, is_needed_only_when_the_guess_is_uncertain) {
  EXPECT_FALSE(needs_search({SE3{}, 0.14, 3.9 * kDegree}, settings));
  EXPECT_TRUE(needs_search({SE3{}, 0.16, 3.9 * kDegree}, settings));
  EXPECT_TRUE(needs_search({SE3{}, 0.14, 4.1 * kDegree}, settings));
}

TEST_F(CoarseSearchTest, only_the_last_ten_scans_are_kept) {
  for (int k = 0; k < 12; ++k) recent.add(now, truth);
  ASSERT_EQ(recent.scans().size(), 10U);
  for (const auto& scan : recent.scans()) EXPECT_EQ(scan.size(), now.size());
  recent.clear();
  EXPECT_TRUE(recent.scans().empty());
}

}  // namespace
}  // namespace rali::odometry
