#include "rali/places/recognise.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "rali/places/world_for_test.hpp"

namespace rali::places {
namespace {

using geometry::SE3;
using geometry::Vec3;
using test::at;
using test::path;

/// Two submaps of one world, and their true relative pose.
struct Two {
  Two(const test::World& world, const SE3& a, const SE3& b, int scans, std::uint64_t seed = 3)
      : rng(seed),
        target(test::map_of(world, path(a, scans), rng, 0.003)),
        source(test::map_of(world, path(b, scans), rng, 0.003)),
        truth(a.inverse() * b) {}

  [[nodiscard]] double error_m(const Placement& p) const {
    return (p.registration.T_target_source.p - truth.p).norm();
  }

  Rng rng;
  Submap target, source;
  SE3 truth;
};

Guess guess_of(const SE3& T, double sigma_m, double sigma_deg) {
  Guess out;
  out.T_target_source = T;
  geometry::Vec6 d;
  d << Vec3::Constant(std::pow(sigma_deg * std::numbers::pi / 180.0, 2)),
      Vec3::Constant(sigma_m * sigma_m);
  out.covariance = d.asDiagonal();
  return out;
}

TEST(recognise, recognises_a_room_without_a_pose_guess) {
  const Two two(test::room(), at(4.0, 4.0, 10.0), at(6.5, 3.5, 200.0), 3);
  RecogniseSettings settings;
  EXPECT_FALSE(recognise(two.target, two.source, settings).usable());  // only the two ends are seen
  settings.stations_min = 2;
  const Recognition r = recognise(two.target, two.source, settings);
  ASSERT_TRUE(r.found());
  EXPECT_EQ(r.certainty, Certainty::kUnique);
  EXPECT_TRUE(r.placements.front().registration.full_rank());
  EXPECT_LT(two.error_m(r.placements.front()), 0.02);
}

TEST(recognise, is_ambiguous_in_a_corridor_with_repeating_doors) {
  test::CorridorOptions o;
  o.half_m = 30.0;
  const Two two(test::corridor(o), at(0.0, 0.2, 1.0), at(2.0, -0.2, 182.0), 11);
  const Recognition r = recognise(two.target, two.source, RecogniseSettings{});
  ASSERT_TRUE(r.found());
  EXPECT_EQ(r.certainty, Certainty::kAmbiguous);
  EXPECT_FALSE(r.usable());
}

TEST(recognise, is_unique_among_repeating_doors_with_a_pose_guess) {
  test::CorridorOptions o;
  o.half_m = 30.0;
  const Two two(test::corridor(o), at(0.0, 0.2, 1.0), at(2.0, -0.2, 182.0), 11);
  SE3 near = two.truth;
  near.p += Vec3(0.4, 0.1, 0.0);
  const Recognition r =
      recognise(two.target, two.source, RecogniseSettings{}, guess_of(near, 0.4, 3.0));
  ASSERT_TRUE(r.found());
  EXPECT_EQ(r.certainty, Certainty::kUnique);
  EXPECT_LT(two.error_m(r.placements.front()), 0.02);
}

TEST(recognise, leaves_the_corridor_axis_unobservable_where_doors_repeat_within_the_guess) {
  test::CorridorOptions o;
  o.half_m = 30.0;
  const Two two(test::corridor(o), at(0.0, 0.2, 1.0), at(2.0, -0.2, 182.0), 11);
  const Recognition r =
      recognise(two.target, two.source, RecogniseSettings{}, guess_of(two.truth, 2.5, 3.0));
  ASSERT_TRUE(r.found());
  EXPECT_EQ(r.certainty, Certainty::kAlongAxis);
  const Registration& best = r.placements.front().registration;
  EXPECT_FALSE(best.full_rank());
  // Information along the axis after marginalising the rotation.
  const geometry::Mat6& I = best.information;
  const geometry::Mat3 rest = I.bottomRightCorner<3, 3>() - I.bottomLeftCorner<3, 3>() *
                                                                I.topLeftCorner<3, 3>().inverse() *
                                                                I.topRightCorner<3, 3>();
  EXPECT_LT(r.axis_target.dot(rest * r.axis_target), 1e-6 * rest.trace());
  EXPECT_NEAR(std::abs(r.axis_target.x()), 1.0, 0.01);
}

TEST(recognise, rejects_an_alignment_rotated_by_180_degrees) {
  const Two two(test::room(), at(6.0, 4.0, 0.0), at(6.0, 4.0, 0.0), 3);
  const Registration r =
      align(two.target, two.source, at(0.0, 0.0, 180.0), RecogniseSettings{}.align);
  const Verdict v = verify(two.target, two.source, r, VerifySettings{});
  EXPECT_FALSE(v.believable());
}

TEST(recognise, does_not_match_two_different_rooms) {
  Rng rng(9);
  test::World other;
  test::add_shell(other, {0.0, 0.0, 0.0}, {7.0, 5.0, 3.0});
  other.push_back({{3.0, 2.0, 0.0}, {3.6, 2.6, 3.0}});
  const Submap a = test::map_of(test::room(), path(at(4.0, 4.0, 0.0), 3), rng);
  const Submap b = test::map_of(other, path(at(2.0, 1.5, 0.0), 3), rng);
  EXPECT_FALSE(recognise(a, b, RecogniseSettings{}).usable());
}

// The result names the check that refused the loop.
TEST(recognise, names_the_check_that_refused_the_loop) {
  const Two two(test::room(), at(6.0, 4.0, 0.0), at(6.0, 4.0, 0.0), 3);
  const std::vector<SE3> starts = {at(0.0, 0.0, 0.0)};
  RecogniseSettings s;
  EXPECT_EQ(recognise_from(two.target, two.source, starts, s).refusal, Refusal::kNone);
  Guess elsewhere{at(9.0, 0.0, 0.0), 1e-4 * geometry::Mat6::Identity()};
  EXPECT_EQ(recognise_from(two.target, two.source, starts, s, elsewhere).refusal,
            Refusal::kOutsideGuess);
  s.verify.upright_min = 100000;
  EXPECT_EQ(recognise_from(two.target, two.source, starts, s).refusal, Refusal::kOverlap);
  EXPECT_EQ(recognise_from(two.target, two.source, {}, s).refusal, Refusal::kNone);
}

TEST(recognise, reports_the_conflict_at_a_wrong_pose_guess) {
  const Two two(test::room(), at(6.0, 4.0, 0.0), at(6.0, 4.0, 0.0), 3);
  const RecogniseSettings s;
  const Recognition right = recognise(two.target, two.source, s, guess_of(two.truth, 0.1, 2.0));
  ASSERT_TRUE(right.found());
  EXPECT_EQ(right.conflict_as_guessed, 0.0);
  Guess wrong = guess_of(two.truth, 0.1, 2.0);
  wrong.T_target_source = wrong.T_target_source * at(2.0, 1.0, 45.0);
  const Recognition none = recognise(two.target, two.source, s, wrong);
  ASSERT_FALSE(none.found());
  EXPECT_GT(none.conflict_as_guessed, 0.3);
}

// 2.7 degrees move the wall of a pipe that is 20 m away by a metre. Registration refuses what it
// cannot tell apart there, and the guess, right within its sigma, counted as contradicted.
TEST(recognise, a_guess_that_is_right_within_its_sigma_is_not_contradicted) {
  Rng rng(7);
  const SE3 a = at(0.0, 0.0, 0.0), b = at(3.0, 0.0, 1.0);
  const Submap target = test::map_of(test::Pipe{}, path(a, 12), rng, 0.003);
  const Submap source = test::map_of(test::Pipe{}, path(b, 1), rng, 0.003);
  RecogniseSettings s;
  s.verify.overlap_min = 1.1;  // nothing is registered
  for (const double yaw_deg : {-2.7, 0.0, 2.7, 15.0}) {
    Guess guess = guess_of(a.inverse() * b, 0.1, 3.0);
    guess.T_target_source = guess.T_target_source * at(0.0, 0.0, yaw_deg);
    const Recognition r = recognise(target, source, s, guess);
    ASSERT_FALSE(r.found());
    EXPECT_EQ(r.conflict_as_guessed > 0.1, yaw_deg > 5.0)
        << yaw_deg << ": " << r.conflict_as_guessed;
  }
}

TEST(recognise, with_a_guess_a_smooth_tunnel_is_degenerate_only_along_its_axis) {
  const Two two(test::tunnel(), at(0.0, 0.2, 1.0), at(2.0, -0.2, 182.0), 7);
  const Recognition r =
      recognise(two.target, two.source, RecogniseSettings{}, guess_of(two.truth, 0.3, 2.0));
  ASSERT_TRUE(r.usable());
  EXPECT_EQ(r.certainty, Certainty::kAlongAxis);
  EXPECT_FALSE(r.placements.front().registration.full_rank());
}

TEST(guess, accepts_only_poses_within_its_gate) {
  const Guess guess = guess_of(at(10.0, 0.0, 0.0), 1.0, 2.0);
  EXPECT_TRUE(within(guess, at(12.9, 0.0, 0.0), 3.0));
  EXPECT_FALSE(within(guess, at(13.3, 0.0, 0.0), 3.0));
  EXPECT_FALSE(within(guess, at(10.0, 0.0, 9.0), 3.0));  // 6 deg and the 1.7 of the minimum gate
  EXPECT_DOUBLE_EQ(horizontal_sigma_m(guess), 1.0);
}

TEST(guess, lets_submaps_overlap_by_their_nearest_views) {
  const NearSettings near;
  const Two one(test::tunnel(), at(0.0, 0.2, 1.0), at(2.0, -0.2, 1.0), 1);
  const auto overlap = [&](const Two& two, double ahead_m, double sigma_m) {
    return may_overlap(two.target, two.source, guess_of(at(ahead_m, 0.0, 0.0), sigma_m, 2.0), near);
  };
  EXPECT_TRUE(overlap(one, 14.9, 1.0));
  EXPECT_FALSE(overlap(one, 15.1, 1.0));
  EXPECT_FALSE(overlap(one, 1.0, 30.0));
  const Two seven(test::tunnel(), at(0.0, 0.2, 1.0), at(2.0, -0.2, 1.0), 7);
  const double length_m = 0.5 * (seven.target.path_m() + seven.source.path_m());
  EXPECT_TRUE(overlap(seven, 14.9 + length_m, 1.0));
  EXPECT_FALSE(overlap(seven, 15.1 + length_m, 1.0));
}

}  // namespace
}  // namespace rali::places
