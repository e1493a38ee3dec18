#include "rali/ranging/anchor_finder.hpp"

#include <cmath>
#include <cstring>
#include <limits>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::ranging {
namespace {

using geometry::Mat3;
using geometry::Vec3;

constexpr double kBiasSigma = 0.1;

/// A drive at 1 m/s past an antenna, with a range every 20 cm.
struct Drive {
  Vec3 antenna_m = Vec3(6.0, 1.0, 0.0);
  bool zigzag = false;
  double noise_m = 0.0;
  double bias_m = 0.0;
  double outliers = 0.0;         ///< fraction of ranges that are 0.5 to 3 m too long
  double drift_mps = 0.0;        ///< error of the estimated speed along x
  double drift_sigma_mps = 0.0;  ///< and its sigma
  std::optional<Vec3> passage;
  std::optional<LateralOffset> by_walls;
  FinderSettings settings;
  std::uint64_t seed = 1;

  double reported_after_m = 0.0;

  [[nodiscard]] Vec3 place(double s_m) const {
    return {s_m, zigzag ? 1.5 * std::sin(0.8 * s_m) : 0.0, 0.0};
  }

  [[nodiscard]] FinderSample sample(double s_m, Rng& rng) const {
    FinderSample out;
    out.t = Time::from_s(100.0 + s_m);
    const Vec3 truth = place(s_m);
    out.p_odom_antenna_m = truth + drift_mps * s_m * Vec3::UnitX();
    out.covariance_m2 = 1e-6 * Mat3::Identity();
    out.covariance_m2(0, 0) += drift_sigma_mps * drift_sigma_mps * s_m * s_m;
    out.range_m = (truth - antenna_m).norm() + bias_m + noise_m * rng.normal();
    if (rng.uniform() < outliers) out.range_m += rng.uniform(0.5, 3.0);
    out.passage_odom = passage;
    out.by_walls = by_walls;
    return out;
  }

  /// The first result within this path length.
  std::optional<FoundAnchor> find(double path_m) {
    AnchorFinder finder(settings, 0.0, kBiasSigma);
    Rng rng(seed, "finder");
    for (int k = 0; 0.2 * k <= path_m; ++k) {
      reported_after_m = 0.2 * k;
      const auto found = finder.add(sample(reported_after_m, rng), 0.0, Vec3::UnitZ());
      if (found) return found;
    }
    return std::nullopt;
  }

  [[nodiscard]] double nees(const FoundAnchor& found) const {
    const Vec3 error = found.p_odom_m - antenna_m;
    return error.dot(found.covariance_m2.inverse() * error);
  }
};

TEST(AnchorFinder, covariance_covers_both_mirror_solutions_of_a_straight_path) {
  // 1 m to one side or 1 m to the other: 2 m apart in y, which the covariance must include.
  Drive drive;
  const auto found = drive.find(20.0);
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->mirrored);
  EXPECT_NEAR(found->p_odom_m.x(), 6.0, 0.02);
  EXPECT_NEAR(std::abs(found->p_odom_m.y()), 1.0, 0.02);
  EXPECT_NEAR(std::sqrt(found->covariance_m2(1, 1)), 2.0, 0.05);
  EXPECT_LT(drive.nees(*found), 1.1);  // on whichever side
  // Along the line of sight it is certain: later ranges constrain the pose by it.
  EXPECT_LT(std::sqrt(found->covariance_m2(0, 0)), 0.05);
}

TEST(AnchorFinder, reports_no_mirrored_position_abeam_of_the_antenna) {
  // At 4 m, the line of sight is across the path, where the sides differ: no range would fit.
  Drive drive;
  drive.antenna_m = Vec3(6.0, 4.0, 0.0);
  drive.settings.travel_again_m = 1.5;
  EXPECT_FALSE(drive.find(14.0));
}

TEST(AnchorFinder, resolves_the_side_from_a_zigzag_path) {
  for (const double side : {-1.0, 1.0}) {
    Drive drive;
    drive.zigzag = true;
    drive.antenna_m = Vec3(6.0, 4.0 * side, 0.0);
    drive.settings.travel_min_m = 4.0;  // a first bend alone is nearly straight
    const auto found = drive.find(6.0);
    ASSERT_TRUE(found) << side;
    EXPECT_FALSE(found->mirrored);
    EXPECT_NEAR(found->p_odom_m.y(), 4.0 * side, 0.1);
    EXPECT_LT(drive.nees(*found), 1.0);
  }
}

TEST(AnchorFinder, in_a_passage_finds_a_far_antenna_after_2_2_m) {
  for (const double sign : {-1.0, 1.0}) {
    Drive drive;
    drive.antenna_m = Vec3(60.0 * sign, 0.0, 0.0);
    drive.passage = Vec3::UnitX();
    const auto found = drive.find(4.0);
    ASSERT_TRUE(found) << sign;
    EXPECT_NEAR(drive.reported_after_m, 2.2, 1e-9);
    // 2 m and 5 % of the range across; 0.3 m and 2 % of it up; along it the sigma and the bias of
    // 0.1 m, and what a lateral offset shortens it by: its square by twice the range.
    const double range_m = 60.0 - sign * 2.2;
    const double across_m = 2.0 + 0.05 * range_m;
    const double nearer_m = across_m * across_m / (2.0 * range_m);
    EXPECT_NEAR(found->p_odom_m.x(), sign * (60.0 - nearer_m), 1e-9);
    EXPECT_NEAR(found->covariance_m2(0, 0), 0.02 + 2.0 * nearer_m * nearer_m, 1e-9);
    EXPECT_NEAR(std::sqrt(found->covariance_m2(1, 1)), across_m, 1e-9);
    EXPECT_NEAR(std::sqrt(found->covariance_m2(2, 2)), 0.3 + 0.02 * range_m, 1e-9);
  }
}

TEST(AnchorFinder, uses_the_lateral_offset_from_walls_of_the_passage) {
  Drive drive;
  drive.antenna_m = Vec3(60.0, 0.0, 0.0);
  drive.passage = Vec3::UnitX();
  drive.by_walls = LateralOffset{0.0, 0.6};
  const auto found = drive.find(4.0);
  ASSERT_TRUE(found);
  // At 57.8 m the lateral sigma is 0.6 + 2.89 m, not 2 + 2.89 m.
  EXPECT_NEAR(found->p_odom_m.x(), 60.0 - 3.49 * 3.49 / (2.0 * 57.8), 1e-6);
  EXPECT_NEAR(std::sqrt(found->covariance_m2(1, 1)), 3.49, 1e-6);
}

TEST(AnchorFinder, accepts_a_passage_axis_of_either_sign) {
  Drive drive;
  drive.antenna_m = Vec3(60.0, 0.0, 0.0);
  drive.passage = Vec3(-Vec3::UnitX());  // an axis has no sign
  const auto found = drive.find(4.0);
  ASSERT_TRUE(found);
  // Found after 2.2 m, at a range of 57.8: less what a lateral offset of 2 + 2.89 m shortens it by.
  EXPECT_NEAR(found->p_odom_m.x(), 60.0 - 4.89 * 4.89 / (2.0 * 57.8), 1e-6);
}

TEST(AnchorFinder, reports_no_far_position_across_a_passage) {
  // Ranges that do not change along the path contradict a peer in the passage.
  Drive drive;
  drive.antenna_m = Vec3(2.0, 60.0, 0.0);
  drive.passage = Vec3::UnitX();
  EXPECT_FALSE(drive.find(8.0));
}

TEST(AnchorFinder, reports_no_position_at_standstill) {
  Drive drive;
  Rng rng(3, "rest");
  AnchorFinder finder(FinderSettings{}, 0.0, kBiasSigma);
  for (int k = 0; k < 2000; ++k) {
    FinderSample s = drive.sample(0.0, rng);
    s.t = Time::from_s(0.05 * k);
    s.range_m += 0.1 * rng.normal();
    EXPECT_FALSE(finder.add(s, 0.0, Vec3::UnitZ()));
  }
  EXPECT_EQ(finder.samples(), 50U);  // one in 2 s
}

TEST(AnchorFinder, does_not_count_pose_noise_at_standstill_as_distance_travelled) {
  // 1 cm of noise on the pose adds up to metres of apparent path within minutes.
  Drive drive;
  drive.settings.directions = 8;
  drive.settings.travel_again_m = 2.0;
  Rng rng(4, "rest");
  AnchorFinder finder(drive.settings, 0.0, kBiasSigma);
  for (int k = 0; k < 400; ++k) {
    FinderSample s = drive.sample(0.0, rng);
    s.t = Time::from_s(2.0 * k);
    s.p_odom_antenna_m += 0.01 * Vec3(rng.normal(), rng.normal(), rng.normal());
    s.range_m += 0.03 * rng.normal();
    EXPECT_FALSE(finder.add(s, 0.0, Vec3::UnitZ())) << k;
  }
}

TEST(AnchorFinder, finds_the_position_despite_a_velocity_error_of_5_cm_per_s) {
  // 5 cm/s too fast with a sigma as large: 0.9 m after 18 m. The position is relative to the start
  // of the ranges, so that the next ranges correct the pose.
  Drive drive;
  drive.antenna_m = Vec3(12.0, 1.0, 0.0);
  drive.drift_mps = drive.drift_sigma_mps = 0.05;
  drive.noise_m = 0.05;
  drive.settings.travel_again_m = 2.0;
  const auto found = drive.find(25.0);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->p_odom_m.x(), 12.0, 0.25);
  EXPECT_LT(drive.nees(*found), 11.3);
}

TEST(AnchorFinder, covariance_includes_the_bias_of_the_pair) {
  Drive drive;
  drive.zigzag = true;
  drive.antenna_m = Vec3(12.0, 3.0, 0.0);
  drive.bias_m = 0.1;
  const auto found = drive.find(10.0);
  ASSERT_TRUE(found);
  EXPECT_NEAR((found->p_odom_m - drive.place(drive.reported_after_m)).norm(),
              (drive.antenna_m - drive.place(drive.reported_after_m)).norm() + 0.1, 0.05);
  EXPECT_LT(drive.nees(*found), 3.0);
}

TEST(AnchorFinder, tolerates_10_percent_outliers_in_the_ranges) {
  int reported = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Drive drive;
    drive.seed = seed;
    drive.zigzag = true;
    drive.antenna_m = Vec3(7.0, -5.0, 0.0);
    drive.noise_m = 0.1;
    drive.outliers = 0.1;
    drive.settings.travel_again_m = 1.0;
    const auto found = drive.find(12.0);
    if (!found) continue;  // too many outliers by chance: better no position than a wrong one
    ++reported;
    EXPECT_LT((found->p_odom_m - drive.antenna_m).norm(), 1.2) << seed;
    EXPECT_LT(drive.nees(*found), 16.3) << seed;
  }
  EXPECT_GE(reported, 7);
}

TEST(AnchorFinder, nees_of_the_positions_is_consistent_over_50_seeds) {
  double sum = 0.0;
  constexpr int kSeeds = 50;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    Rng rng(seed, "place");
    Drive drive;
    drive.seed = seed;
    drive.zigzag = true;
    drive.noise_m = 0.1;
    const double azimuth = rng.uniform(-3.14, 3.14);
    const double away_m = rng.uniform(4.0, 20.0);
    drive.antenna_m = {away_m * std::cos(azimuth), away_m * std::sin(azimuth), 0.2 * rng.normal()};
    drive.bias_m = 0.08 * rng.normal();
    drive.settings.directions = 12;
    const auto found = drive.find(12.0);
    ASSERT_TRUE(found) << seed;
    const double nees = drive.nees(*found);
    EXPECT_LT(nees, 16.3) << seed;  // 0.1 % of good ones are above
    sum += nees;
  }
  EXPECT_LT(sum / kSeeds, 3.8);  // 3 and twice the sd of a mean of 50
  EXPECT_GT(sum / kSeeds, 1.0);  // nor is the covariance too large
}

TEST(AnchorFinder, skips_samples_that_are_not_finite_or_have_no_sigma) {
  const double nan = std::nan("");
  const double inf = std::numeric_limits<double>::infinity();
  Drive drive;
  drive.zigzag = true;
  drive.antenna_m = Vec3(6.0, 4.0, 0.0);
  Rng rng(1, "finder");
  AnchorFinder finder(FinderSettings{}, 0.0, kBiasSigma);
  std::optional<FoundAnchor> found;
  for (int k = 0; k < 30 && !found; ++k) {
    const FinderSample good = drive.sample(0.2 * k, rng);
    for (const double bad : {nan, inf, -inf}) {
      FinderSample s = good;
      s.range_m = bad;
      EXPECT_FALSE(finder.add(s, 0.0, Vec3::UnitZ()));
      s = good;
      s.p_odom_antenna_m.y() = bad;
      EXPECT_FALSE(finder.add(s, 0.0, Vec3::UnitZ()));
      s = good;
      s.covariance_m2(0, 1) = bad;
      EXPECT_FALSE(finder.add(s, 0.0, Vec3::UnitZ()));
    }
    for (const double sigma_m : {0.0, -1.0, nan}) {
      FinderSample s = good;
      s.sigma_m = sigma_m;
      EXPECT_FALSE(finder.add(s, 0.0, Vec3::UnitZ()));
    }
    found = finder.add(good, 0.0, Vec3::UnitZ());
  }
  ASSERT_TRUE(found) << "broken samples must not spoil the good ones";
  EXPECT_LT(drive.nees(*found), 1.0);
}

TEST(AnchorFinder, nonsensical_ranges_give_finite_output_and_bounded_memory) {
  Rng rng(9, "hostile");
  FinderSettings settings;
  settings.directions = 4;
  settings.iterations = 5;
  settings.samples_max = 20;
  AnchorFinder finder(settings, 0.0, kBiasSigma);
  for (int k = 0; k < 400; ++k) {
    FinderSample s;
    s.t = Time::from_s(rng.uniform(-1e6, 1e6));
    s.p_odom_antenna_m = 1e9 * Vec3(rng.normal(), rng.normal(), rng.normal());
    s.range_m = k % 3 == 0 ? -5.0 : 1e12 * rng.uniform();
    s.passage_odom = Vec3::UnitX();
    const auto found = finder.add(s, 0.0, Vec3::UnitZ());
    if (found) {
      EXPECT_TRUE(found->p_odom_m.allFinite());
    }
    EXPECT_LE(finder.samples(), 20U);
  }
}

TEST(AnchorFinder, the_same_ranges_give_the_same_bytes) {
  Drive a;
  a.zigzag = true;
  a.noise_m = 0.1;
  Drive b = a;
  const auto first = a.find(12.0);
  const auto second = b.find(12.0);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(std::memcmp(first->p_odom_m.data(), second->p_odom_m.data(), sizeof(Vec3)), 0);
  EXPECT_EQ(std::memcmp(first->covariance_m2.data(), second->covariance_m2.data(), sizeof(Mat3)),
            0);
}

TEST(AnchorFinder, works_with_any_up_axis) {
  // The same drive with x up: what was level is y and z.
  Drive drive;
  drive.zigzag = true;
  drive.antenna_m = Vec3(6.0, 4.0, 0.0);
  Rng rng(1, "finder");
  AnchorFinder finder(FinderSettings{}, 0.0, kBiasSigma);
  std::optional<FoundAnchor> found;
  for (int k = 0; k < 30 && !found; ++k) {
    FinderSample s = drive.sample(0.2 * k, rng);
    const Vec3 p = s.p_odom_antenna_m;
    s.p_odom_antenna_m = Vec3(p.z(), p.x(), p.y());
    found = finder.add(s, 0.0, Vec3::UnitX());
  }
  ASSERT_TRUE(found);
  EXPECT_LT((found->p_odom_m - Vec3(0.0, 6.0, 4.0)).norm(), 0.2);
}

TEST(AnchorFinder, uses_the_given_height_difference_of_the_antennas) {
  // 3 m higher and 4 m ahead: 5 m of range.
  Drive drive;
  drive.antenna_m = Vec3(8.0, 1.5, 3.0);
  drive.zigzag = true;
  Rng rng(1, "finder");
  AnchorFinder finder(FinderSettings{}, 0.0, kBiasSigma);
  std::optional<FoundAnchor> found;
  for (int k = 0; k < 40 && !found; ++k) {
    found = finder.add(drive.sample(0.2 * k, rng), 3.0, Vec3::UnitZ());
  }
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->p_odom_m.z(), 3.0, 0.1);
  EXPECT_LT(drive.nees(*found), 1.0);
}

TEST(AnchorFinder, starts_without_samples_after_a_reset) {
  Drive drive;
  drive.zigzag = true;
  Rng rng(1, "finder");
  AnchorFinder finder(FinderSettings{}, 0.0, kBiasSigma);
  for (int k = 0; k < 9; ++k)
    static_cast<void>(finder.add(drive.sample(0.2 * k, rng), 0.0, Vec3::UnitZ()));
  EXPECT_EQ(finder.samples(), 9U);
  finder.reset();
  EXPECT_EQ(finder.samples(), 0U);
  // Nine more are 1.6 m of path: not enough on their own.
  for (int k = 9; k < 18; ++k) {
    EXPECT_FALSE(finder.add(drive.sample(0.2 * k, rng), 0.0, Vec3::UnitZ()));
  }
}

}  // namespace
}  // namespace rali::ranging
