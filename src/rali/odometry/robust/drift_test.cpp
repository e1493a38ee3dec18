#include "rali/odometry/robust/drift.hpp"

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <gtest/gtest.h>

namespace rali::odometry {
namespace {

using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;

/// All directions are observable by the LiDAR.
const MapFollowing kFollows = MapFollowing::all();

Mat6 local(double sigma_rad, double sigma_m) {
  Mat6 P = Mat6::Zero();
  P.diagonal().head<3>().setConstant(sigma_rad * sigma_rad);
  P.diagonal().tail<3>().setConstant(sigma_m * sigma_m);
  return P;
}

SE3 at(double x_m) { return {geometry::Mat3::Identity(), Vec3(x_m, 0.0, 0.0)}; }

double sigma_x(const Mat6& P) { return std::sqrt(P(3, 3)); }

/// Drift that starts at zero and grows by one registration per generation.
DriftSettings from_nothing() {
  DriftSettings settings;
  settings.start_sigma_m = settings.start_sigma_deg = settings.start_tilt_deg = 0.0;
  settings.growth = 1.0;
  return settings;
}

TEST(Drift, starts_with_the_uncertainty_of_the_first_pose) {
  Drift drift{DriftSettings{}};
  const geometry::Mat6 P = drift.update(geometry::SE3{}, 0.0, geometry::Mat6::Zero(), kFollows);
  EXPECT_NEAR(std::sqrt(P(0, 0)), 0.06 * 3.14159265 / 180.0, 1e-9);
  EXPECT_NEAR(std::sqrt(P(2, 2)), 0.05 * 3.14159265 / 180.0, 1e-9);
  // 4 mm, and the tilt about a point 0.5 m above and 3 m ahead.
  EXPECT_NEAR(std::sqrt(P(3, 3)), std::hypot(0.004, 0.5 * 0.06 * 3.14159265 / 180.0), 1e-9);
  EXPECT_NEAR(std::sqrt(P(5, 5)), std::hypot(0.004, 3.0 * 0.06 * 3.14159265 / 180.0), 1e-9);
}

TEST(Drift, equals_the_registration_covariance_while_the_first_planes_are_matched) {
  Drift drift{from_nothing()};
  const Mat6 P = local(1e-3, 0.005);
  for (int k = 0; k < 50; ++k) {
    EXPECT_LT((drift.update(at(0.005 * k), 0.0, P, kFollows) - P).norm(), 1e-15);
  }
  EXPECT_EQ(drift.epoch(), 0U);
}

TEST(Drift, turns_the_map_by_one_registration_per_generation_of_planes) {
  Drift drift{from_nothing()};
  const Mat6 P = local(1e-3, 0.0);
  drift.update(at(0.0), 0.0, P, kFollows);
  EXPECT_TRUE(drift.take_rotation().isZero(0.0)) << "no new generation";
  drift.update(at(0.6), 0.0, P, kFollows);
  EXPECT_NEAR(drift.take_rotation()(1, 1), 1e-6, 1e-15);
  EXPECT_TRUE(drift.take_rotation().isZero(0.0)) << "taken";
  // A LiDAR that sees far ahead registers with planes of many generations ago.
  for (int k = 2; k <= 10; ++k) drift.update(at(0.6 * k), 0.0, P, kFollows);
  double sum = 1.0;  // the second generation
  for (int passed = 2; passed < 10; ++passed) sum += 1.0 / passed;
  EXPECT_NEAR(drift.take_rotation()(1, 1), 1e-6 * sum, 1e-12);
}

TEST(Drift, adds_one_registration_variance_per_generation_of_planes) {
  Drift drift{from_nothing()};
  const Mat6 P = local(0.0, 0.01);
  Mat6 seen = P;
  for (int k = 1; k <= 25; ++k) {
    // Always matched with the newest planes: each half metre is a generation.
    seen = drift.update(at(0.51 * k), static_cast<double>(drift.epoch()), P, kFollows);
  }
  EXPECT_EQ(drift.epoch(), 25U);
  // 24 generations add the error of one registration each, plus this one's own.
  EXPECT_NEAR(sigma_x(seen), 0.01 * std::sqrt(25.0), 1e-9);
}

// LiDAR alone: the second scan finds too few planes in a map of one scan, the third finds enough.
TEST(Drift, a_generation_inherits_the_covariance_of_its_first_mapping_pose) {
  Drift drift{from_nothing()};
  const Mat6 guessed = local(0.05, 0.3);
  const Mat6 known = local(1e-3, 0.01);
  const Mat6 second = drift.update(at(0.3), 0.0, guessed, MapFollowing::nothing());
  EXPECT_NEAR(sigma_x(second), 0.3, 1e-9);
  ASSERT_EQ(drift.epoch(), 1U) << "it knows much less than the first";
  drift.update(at(0.4), 0.0, known, kFollows);
  // Only now does the generation have planes.
  EXPECT_NEAR(sigma_x(drift.update(at(0.5), 1.0, known, kFollows)), 0.01 * std::sqrt(2.0), 1e-3);
  // A pose that stays uncertain makes planes of the same uncertainty.
  Drift lost{from_nothing()};
  for (int k = 0; k < 2; ++k) lost.update(at(0.3), 0.0, guessed, MapFollowing::nothing());
  EXPECT_NEAR(sigma_x(lost.update(at(0.4), 1.0, known, kFollows)), 0.3, 0.02);
}

TEST(Drift, decreases_on_return_to_the_first_planes) {
  Drift drift{from_nothing()};
  const Mat6 P = local(1e-3, 0.01);
  Mat6 far = P;
  for (int k = 1; k <= 40; ++k) far = drift.update(at(0.51 * k), drift.epoch(), P, kFollows);
  const Mat6 home = drift.update(at(0.2), 0.0, P, kFollows);
  EXPECT_GT(sigma_x(far), 5.0 * sigma_x(home));
  EXPECT_LT((home - P).norm(), 1e-15);
  // New planes observed from here inherit little error again.
  const Mat6 next = drift.update(at(0.8), drift.epoch(), P, kFollows);
  EXPECT_LT(sigma_x(next), 2.0 * sigma_x(P));
}

TEST(Drift, a_heading_error_causes_lateral_error_in_proportion_to_distance) {
  Drift drift{from_nothing()};
  Mat6 P = Mat6::Zero();
  P(2, 2) = 1e-6;  // 1 mrad of heading per registration
  P.diagonal().tail<3>().setConstant(1e-12);
  static_cast<void>(
      drift.update(at(0.6), 0.0, P, kFollows));  // generation 1 turns by 1 mrad about x = 0.6
  const Mat6 far = drift.update(at(100.6), 1.0, Mat6::Zero(), kFollows);
  EXPECT_NEAR(std::sqrt(far(4, 4)), 0.1, 1e-3);  // 100 m away: 10 cm laterally
  EXPECT_NEAR(std::sqrt(far(2, 2)), 1e-3, 1e-6);
  EXPECT_NEAR(sigma_x(far), 0.0, 1e-3);
}

// In a bent tunnel the heading error follows the position error along it. A vehicle that has left
// the tunnel keeps both, although all directions are observable again.
TEST(Drift, heading_uncertainty_from_a_bend_remains_after_it) {
  Drift drift{from_nothing()};
  const Mat6 P = local(1e-4, 1e-3);
  Mat6 turned = Mat6::Zero();
  Mat6 inside = P;
  for (int k = 1; k <= 40; ++k) {
    turned(2, 2) = std::pow(1e-3 * k, 2);
    inside = drift.update(at(0.51 * k), drift.epoch(), P, kFollows, std::nullopt, {}, turned);
  }
  EXPECT_NEAR(std::sqrt(inside(2, 2)), 0.04, 1e-3) << "once, not once more by each generation";
  Mat6 behind = inside;
  for (int k = 41; k <= 44; ++k) behind = drift.update(at(0.51 * k), drift.epoch(), P, kFollows);
  EXPECT_NEAR(std::sqrt(behind(2, 2)), 0.04, 2e-3);
  EXPECT_LT(std::sqrt(drift.update(at(0.1), 0.0, P, kFollows)(2, 2)), 1e-3)
      << "at the first planes";
}

TEST(Drift, interpolates_between_generations_and_clamps_beyond_them) {
  Drift drift{from_nothing()};
  const Mat6 P = local(0.0, 0.01);
  for (int k = 1; k <= 4; ++k)
    static_cast<void>(drift.update(at(0.51 * k), drift.epoch(), P, kFollows));
  const double two = drift.update(at(2.04), 2.0, P, kFollows)(3, 3);
  const double three = drift.update(at(2.04), 3.0, P, kFollows)(3, 3);
  EXPECT_NEAR(drift.update(at(2.04), 2.5, P, kFollows)(3, 3), 0.5 * (two + three), 1e-12);
  const double newest = drift.update(at(2.04), 4.0, P, kFollows)(3, 3);
  EXPECT_DOUBLE_EQ(drift.update(at(2.04), 1e9, P, kFollows)(3, 3), newest);
  EXPECT_DOUBLE_EQ(drift.update(at(2.04), -5.0, P, kFollows)(3, 3), P(3, 3));
}

TEST(Drift, planes_are_established_after_further_travel_not_after_time) {
  Drift drift{from_nothing()};
  const Mat6 P = local(0.0, 0.001);
  const auto go = [&](double x_m) {
    static_cast<void>(drift.update(at(x_m), drift.epoch(), P, kFollows));
  };
  go(0.0);
  EXPECT_EQ(drift.newest_established(), 0.0) << "the first map";
  for (const double x_m : {0.6, 1.2, 1.8}) go(x_m);  // each starts a generation
  ASSERT_EQ(drift.epoch(), 3U);
  EXPECT_EQ(drift.newest_established(), 0.0) << "the first ended at 1.2 m";
  go(1.84);
  EXPECT_EQ(drift.newest_established(), 0.0);
  go(2.2);
  go(2.5);
  EXPECT_EQ(drift.newest_established(), 1.0) << "that of 0.6 m ended 1.3 m ago";
  for (int k = 0; k < 1000; ++k) go(2.5 + 0.01 * (k % 2));
  EXPECT_EQ(drift.newest_established(), 1.0) << "time alone establishes nothing";
  go(0.0);
  EXPECT_GE(drift.newest_established(), 1.0) << "nor is it forgotten on return";
}

// A start in motion rebuilds its map after a metre or two, and so does a vehicle that was lost: if
// all planes counted as young, none of them could constrain the vehicle.
TEST(Drift, planes_of_a_rebuilt_map_count_as_established) {
  Drift drift{from_nothing()};
  const Mat6 P = local(0.0, 0.001);
  for (const double x_m : {0.0, 0.6, 1.2}) {
    static_cast<void>(drift.update(at(x_m), drift.epoch(), P, kFollows));
  }
  ASSERT_EQ(drift.epoch(), 2U);
  ASSERT_EQ(drift.newest_established(), 0.0);
  drift.establish_all();
  EXPECT_EQ(drift.newest_established(), 2.0);
  static_cast<void>(drift.update(at(1.8), drift.epoch(), P, kFollows));
  EXPECT_EQ(drift.newest_established(), 2.0) << "what comes after has to grow old";
  drift.add(at(1.8), P);
  EXPECT_EQ(drift.newest_established(), static_cast<double>(drift.epoch()));
}

/// Drives to `to_m`, always matched with the newest planes.
void drive(Drift& drift, double from_m, double to_m, const Mat6& P, const MapFollowing& following) {
  for (double x_m = from_m; x_m <= to_m; x_m += 0.51) {
    static_cast<void>(drift.update(at(x_m), drift.epoch(), P, following));
  }
}

/// Follows the map in all directions except x.
MapFollowing degenerate_along_x() {
  MapFollowing following = MapFollowing::all();
  following.follows(3, 3) = 0.0;
  following.keeps(3, 3) = 1.0;
  return following;
}

// The error from a degenerate stretch does not vanish when a new niche comes into view: its planes
// have the same error. Walls older than the stretch do not constrain that direction.
TEST(Drift, planes_mapped_in_a_degenerate_stretch_keep_its_error) {
  Drift drift{from_nothing()};
  drive(drift, 0.51, 5.0, local(1e-4, 0.001), kFollows);
  const double old = drift.epoch();
  drive(drift, 5.1, 10.0, local(1e-4, 0.7), degenerate_along_x());
  const double now = drift.epoch();
  // The newest generation has no planes yet: the niche was observed in the stretch.
  const HeldAlong niche{Vec3::UnitX(), now - 1.0};
  const Mat6 P = local(1e-4, 0.001);
  EXPECT_LT(sigma_x(drift.update(at(10.2), old, P, kFollows)), 0.01) << "back at the old planes";
  EXPECT_GT(sigma_x(drift.update(at(10.2), old, P, kFollows, {}, {&niche, 1})), 0.69);
}

// In a degenerate stretch the estimate may not move although the vehicle drives: planes first
// observed then belong to a later generation than those before.
TEST(Drift, starts_a_generation_when_uncertainty_grows_without_motion) {
  Drift drift{from_nothing()};
  drive(drift, 0.51, 5.0, local(1e-4, 0.001), kFollows);
  const std::uint32_t before = drift.epoch();
  static_cast<void>(drift.update(at(5.0), before, local(1e-4, 0.001), kFollows));
  EXPECT_EQ(drift.epoch(), before);
  static_cast<void>(drift.update(at(5.0), before, local(1e-4, 1.0), degenerate_along_x()));
  EXPECT_EQ(drift.epoch(), before + 1);
  static_cast<void>(drift.update(at(5.0), before, local(1e-4, 1.1), degenerate_along_x()));
  EXPECT_EQ(drift.epoch(), before + 1) << "not for a little more";
  const HeldAlong fresh{Vec3::UnitX(), static_cast<double>(drift.epoch())};
  const Mat6 P = drift.update(at(5.0), before, local(1e-4, 0.001), kFollows, {}, {&fresh, 1});
  EXPECT_GT(sigma_x(P), 0.9);
}

TEST(Drift, keeps_its_error_along_a_direction_that_became_degenerate) {
  Drift drift{from_nothing()};
  drive(drift, 0.51, 20.0, local(0.0, 0.02), kFollows);
  const double before = sigma_x(drift.update(at(20.1), drift.epoch(), Mat6::Zero(), kFollows));
  EXPECT_GT(before, 0.1);
  // Walls observed from the start: the lateral error is gone, that along x is not.
  const Mat6 after = drift.update(at(20.2), 0.0, Mat6::Zero(), degenerate_along_x());
  EXPECT_NEAR(sigma_x(after), before, 1e-9);
  EXPECT_NEAR(after(4, 4), 0.0, 1e-12);
}

TEST(Drift, releases_the_error_along_a_direction_to_the_filter) {
  Drift drift{from_nothing()};
  drive(drift, 0.51, 20.0, local(0.0, 0.02), kFollows);
  const Mat6 before = drift.update(at(20.1), drift.epoch(), Mat6::Zero(), kFollows);
  const geometry::Mat3 along_x = Vec3::UnitX() * Vec3::UnitX().transpose();
  const geometry::Mat3 released = drift.release(at(20.1), along_x);
  EXPECT_NEAR(released(0, 0), before(3, 3), 1e-12);
  EXPECT_NEAR(released(1, 1), 0.0, 1e-12);
  EXPECT_NEAR(drift.map_error()(3, 3), 0.0, 1e-12);
  EXPECT_NEAR(drift.map_error()(4, 4), before(4, 4), 1e-12);
  EXPECT_NEAR(drift.update(at(20.2), 0.0, Mat6::Zero(), degenerate_along_x())(3, 3), 0.0, 1e-12);
}

// With a ninth of the information of the prediction, a tenth of the variance comes from the map.
TEST(MapFollowing, follows_squared_equals_the_kalman_gain) {
  const Mat6 P = local(1e-3, 0.1);
  const Mat6 information = (P.inverse() / 9.0).eval();
  const MapFollowing following = MapFollowing::of(P, information);
  EXPECT_LT((following.follows * following.follows - 0.1 * Mat6::Identity()).norm(), 1e-9);
  EXPECT_LT((following.keeps * following.keeps - 0.9 * Mat6::Identity()).norm(), 1e-9);
  EXPECT_LT((MapFollowing::of(P, Mat6::Zero()).follows).norm(), 1e-12);
}

TEST(Drift, stays_finite_while_the_heading_is_not_observable) {
  // Six things in an open yard: the covariance overflowed within a minute.
  Drift drift{from_nothing()};
  double before = 0.0;
  for (int k = 0; k < 2000; ++k) {
    const SE3 T = at(0.6 * k);
    const Mat6 P = drift.update(T, drift.epoch(), local(0.5, 1.0), kFollows);
    ASSERT_TRUE(P.allFinite()) << k;
    ASSERT_GE(P(4, 4), 0.0) << k;
    if (k == 1000) before = P(4, 4);
    if (k == 1999) {
      EXPECT_LT(P(4, 4), 20.0 * before) << "it grows with the distance";
    }
    EXPECT_LT(P(2, 2), 3.3 + 0.26) << k;
  }
}

TEST(Drift, an_ambiguous_place_keeps_its_error_also_on_old_planes) {
  // The vehicle may be at another rib of the same old map: matching it there proves nothing.
  Drift drift{from_nothing()};
  const Mat6 P = local(0.0, 0.01);
  for (int k = 0; k < 40; ++k) drift.update(at(0.1 * k), drift.epoch(), P, kFollows);
  Mat6 spread = Mat6::Zero();
  spread(3, 3) = 9.0;
  drift.add_everywhere(at(4.0), spread);
  EXPECT_NEAR(sigma_x(drift.update(at(0.0), 0.0, P, kFollows)), 3.0, 0.01);
  EXPECT_NEAR(sigma_x(drift.update(at(4.0), drift.epoch(), P, kFollows)), 3.0, 0.01);
}

TEST(Drift, without_gravity_the_initial_tilt_sigma_is_0_5_degrees) {
  Drift drift{DriftSettings{}, false};
  const Mat6 P = drift.update(SE3{}, 0.0, Mat6::Zero(), kFollows);
  const double degree = 3.14159265 / 180.0;
  EXPECT_NEAR(std::sqrt(P(0, 0)), 0.5 * degree, 1e-9);
  EXPECT_NEAR(std::sqrt(P(1, 1)), 0.5 * degree, 1e-9);
  EXPECT_NEAR(std::sqrt(P(2, 2)), 0.05 * degree, 1e-9);
}

/// Gravity determines roll and pitch, with this sigma.
Level level(double sigma_rad) {
  Level out;
  out.axes_odom = Eigen::Matrix<double, 3, 2>::Identity();
  out.covariance = sigma_rad * sigma_rad * Eigen::Matrix2d::Identity();
  return out;
}

TEST(Drift, gravity_bounds_roll_and_pitch_but_not_heading) {
  DriftSettings settings = from_nothing();
  settings.start_tilt_deg = 0.1;
  const Mat6 P = local(1e-3, 0.005);
  Drift free{settings}, held{settings};
  Mat6 wanders = P, bounded = P;
  for (int k = 1; k <= 100; ++k) {
    wanders = free.update(at(0.51 * k), free.epoch(), P, kFollows);
    bounded = held.update(at(0.51 * k), held.epoch(), P, kFollows, level(0.001));
  }
  EXPECT_NEAR(wanders(0, 0), 100e-6, 5e-6);
  // The first pose (0.1 degrees), gravity, and this registration.
  const double allowed = 3.046e-6 + 1e-6 + 1e-6;
  EXPECT_NEAR(bounded(0, 0), allowed, 1e-8);
  EXPECT_NEAR(bounded(1, 1), allowed, 1e-8);
  EXPECT_NEAR(bounded(2, 2), wanders(2, 2), 1e-8);
  EXPECT_LT(bounded(5, 5), 0.2 * wanders(5, 5)) << "nor the height that tilt has cost";
  EXPECT_NEAR(bounded(4, 4), wanders(4, 4), 1e-3 * wanders(4, 4)) << "aside counts the heading";
  EXPECT_GT(bounded.ldlt().vectorD().minCoeff(), 0.0);
}

TEST(Drift, a_tilt_measured_by_gravity_adds_its_height_error) {
  // Evenly over 51 m, up to 0.01 rad about y: half of 51 m times 0.01.
  Drift straight{from_nothing()}, bent{from_nothing()};
  const Mat6 P = local(1e-4, 0.005);
  Mat6 without = P, with = P;
  for (int k = 1; k <= 100; ++k) {
    Level shown = level(0.001);
    without = straight.update(at(0.51 * k), straight.epoch(), P, kFollows, shown);
    shown.tilt_rad.y() = 1e-4 * k;
    with = bent.update(at(0.51 * k), bent.epoch(), P, kFollows, shown);
  }
  const Mat6 more = with - without;
  EXPECT_NEAR(more(1, 1), 1e-4, 1e-9);
  EXPECT_NEAR(std::sqrt(more(5, 5)), 0.01 * 0.5 * 51.0, 0.003);
  EXPECT_LT(more(1, 5), 0.0) << "nose down, and lower";
  EXPECT_LT(std::abs(more(0, 0)) + std::abs(more(3, 3)) + std::abs(more(4, 4)), 1e-12);
}

TEST(Drift, repeated_gravity_bounds_do_not_reduce_the_covariance) {
  Drift drift{DriftSettings{}};
  const Mat6 P = local(1e-4, 0.005);
  const Mat6 once = drift.update(at(0.1), 0.0, P, kFollows, level(0.001));
  Mat6 often = once;
  for (int k = 0; k < 100; ++k) often = drift.update(at(0.1), 0.0, P, kFollows, level(0.001));
  EXPECT_LT((often - once).norm(), 1e-15);
  EXPECT_LT((drift.update(at(0.1), 0.0, P, kFollows) - once).norm(), 1e-15) << "nothing above it";
}

}  // namespace
}  // namespace rali::odometry
