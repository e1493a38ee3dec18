#include <cmath>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "rali/sim/radio/places_for_test.hpp"

namespace rali::sim {
namespace {

using geometry::Vec3;

constexpr Time kStart = kTestStart;

/// Errors of `count` exchanges at 10 Hz.
std::vector<double> errors(UwbModel& model, const RadioEnd& a, const RadioEnd& b,
                           const RayCaster& world, int count) {
  std::vector<double> found;
  for (int i = 0; i < count; ++i) {
    const auto sample = model.measure(at_s(0.1 * i), a, b, world);
    if (sample) found.push_back(sample->range_m - model.last_truth().distance_m);
  }
  return found;
}

TEST(UwbModel, without_errors_ranges_are_between_antennas_not_body_origins) {
  UwbModel model(UwbOptions::ideal(), 2, 1);
  RadioEnd a = end_at(0, {0, 0, 0}, M_PI / 2.0);
  RadioEnd b = end_at(1, {10, 0, 0});
  a.p_body_antenna = {0.5, 0.0, 0.3};   // turned by 90 deg: (0, 0.5, 0.3)
  b.p_body_antenna = {-0.2, 0.0, 0.7};  // (9.8, 0, 0.7)
  const auto sample = model.measure(kStart, a, b, open_air());
  ASSERT_TRUE(sample.has_value());
  EXPECT_NEAR(sample->range_m, std::sqrt(9.8 * 9.8 + 0.25 + 0.16), 1e-12);
  EXPECT_EQ(sample->t, kStart);
  EXPECT_EQ(sample->from.value, 0);
  EXPECT_EQ(sample->to.value, 1);
  // 20 dB below the power at 1 m; all power is in the first path.
  EXPECT_NEAR(sample->rssi_dbm, -52.0 - 20.0 * std::log10(sample->range_m), 1e-9);
  EXPECT_NEAR(sample->first_path_dbm, sample->rssi_dbm, 1e-9);
  EXPECT_FALSE(model.last_truth().obstructed);
}

TEST(UwbModel, a_wall_lengthens_the_range_by_thickness_times_refractive_index_minus_one) {
  UwbOptions o = UwbOptions::ideal();
  o.wall_index = 2.2;
  o.wall_loss_db = 2.0;
  o.wall_loss_db_per_m = 25.0;
  UwbModel model(o, 2, 1);
  const auto sample =
      model.measure(kStart, end_at(0, {0, 0, 1}), end_at(1, {10, 0, 1}), one_wall());
  ASSERT_TRUE(sample.has_value());
  EXPECT_NEAR(sample->range_m, 10.0 + 0.2 * 1.2, 1e-5);
  EXPECT_TRUE(model.last_truth().obstructed);
  EXPECT_NEAR(model.last_truth().excess_m, 0.24, 1e-5);
  // 2 dB + 0.2 m * 25 dB/m = 7 dB: the first path loses all of it, the total half.
  EXPECT_NEAR(sample->first_path_dbm, -72.0 - 7.0, 1e-3);
  EXPECT_NEAR(sample->rssi_dbm, -72.0 - 3.5, 1e-3);
}

TEST(UwbModel, angle_dependent_bias_is_the_sum_of_both_antenna_patterns) {
  EXPECT_NEAR((AntennaPattern{0.03, 0.02, 0.01, 0.005}.at(0.0)), 0.04, 1e-12);
  EXPECT_NEAR((AntennaPattern{0.03, 0.02, 0.01, 0.005}.at(M_PI / 2.0)), 0.01, 1e-12);
  UwbOptions o = UwbOptions::ideal();
  o.angle_bias_m = 0.05;
  UwbModel model(o, 2, 7);
  // b is at 90 deg to the left of the world's x; a has a heading of 30 deg, b of 200 deg.
  const double yaw_a = M_PI / 6.0;
  const double yaw_b = 200.0 * M_PI / 180.0;
  const auto sample =
      model.measure(kStart, end_at(0, {0, 0, 1}, yaw_a), end_at(1, {0, 8, 1}, yaw_b), open_air());
  ASSERT_TRUE(sample.has_value());
  const double expected =
      model.pattern(0, 0).at(M_PI / 2.0 - yaw_a) + model.pattern(1, 0).at(-M_PI / 2.0 - yaw_b);
  EXPECT_GT(std::abs(expected), 1e-3);
  EXPECT_NEAR(sample->range_m - 8.0, expected, 1e-9);
  EXPECT_NEAR(model.last_truth().bias_m, expected, 1e-9);
}

TEST(UwbModel, patterns_and_pair_biases_have_the_set_mean_and_sigma) {
  UwbOptions o = UwbOptions::ideal();
  o.angle_bias_m = 0.04;
  o.pair_bias_m = 0.10;
  o.pair_bias_sd_m = 0.06;
  std::vector<double> bias, angle;
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    const UwbModel model(o, 2, seed);
    bias.push_back(model.pair_bias_m(0, 0, 1, 0));
    angle.push_back(model.pattern(1, 0).at(0.3));
  }
  EXPECT_NEAR(moments(bias).mean, 0.10, 0.006);
  EXPECT_NEAR(moments(bias).sd, 0.06, 0.004);
  EXPECT_NEAR(moments(angle).mean, 0.0, 0.004);
  EXPECT_NEAR(moments(angle).sd, 0.04, 0.003);
}

TEST(UwbModel, noise_variance_grows_with_the_square_of_the_distance) {
  UwbOptions o = UwbOptions::ideal();
  o.sigma_m = 0.03;
  o.sigma_per_m = 0.001;
  UwbModel model(o, 2, 1);
  const RayCaster air = open_air();
  const auto near = errors(model, end_at(0, {0, 0, 1}), end_at(1, {1, 0, 1}), air, 5000);
  EXPECT_NEAR(moments(near).sd, 0.03, 0.0015);
  const auto far = errors(model, end_at(0, {0, 0, 1}), end_at(1, {40, 0, 1}), air, 5000);
  EXPECT_NEAR(moments(far).sd, 0.05, 0.0025);
  EXPECT_NEAR(moments(far).mean, 0.0, 0.003);
}

TEST(UwbModel, far_bias_reaches_63_percent_at_its_scale) {
  UwbOptions o = UwbOptions::ideal();
  o.far_bias_m = 0.3;
  o.far_bias_scale_m = 16.0;
  UwbModel model(o, 2, 1);
  const auto sample =
      model.measure(kStart, end_at(0, {0, 0, 1}), end_at(1, {16, 0, 1}), open_air());
  ASSERT_TRUE(sample.has_value());
  EXPECT_NEAR(sample->range_m - 16.0, 0.3 * (1.0 - std::exp(-1.0)), 1e-9);
}

TEST(UwbModel, loss_and_outliers_have_their_fractions) {
  UwbOptions o = UwbOptions::ideal();
  o.loss_fraction = 0.1;
  o.outlier_fraction = 0.05;
  o.outlier_m = 4.0;
  UwbModel model(o, 2, 2);
  const auto found = errors(model, end_at(0, {0, 0, 1}), end_at(1, {60, 0, 1}), open_air(), 20000);
  EXPECT_NEAR(static_cast<double>(found.size()) / 20000.0, 0.9, 0.01);
  std::vector<double> gross;
  for (const double e : found) {
    if (e != 0.0) gross.push_back(std::abs(e));
  }
  EXPECT_NEAR(static_cast<double>(gross.size()) / static_cast<double>(found.size()), 0.05, 0.006);
  EXPECT_NEAR(moments(gross).mean, 4.0, 0.5);
}

TEST(UwbModel, ranges_through_a_wall_are_longer_noisier_and_correlated) {
  const RayCaster world = one_wall();
  const RayCaster air = open_air();
  UwbOptions o;
  o.multipath_m = 0.0;  // without the wall's own reflection
  o.outlier_fraction = 0.0;
  UwbModel model(o, 2, 4), free(o, 2, 4);
  const RadioEnd a = end_at(0, {0, 0, 1});
  const RadioEnd b = end_at(1, {10, 0, 1});
  const auto blocked = errors(model, a, b, world, 20000);
  const auto clear = errors(free, a, b, air, 20000);
  EXPECT_GT(moments(blocked).mean, moments(clear).mean + 0.15);
  EXPECT_GT(moments(blocked).sd, 2.0 * moments(clear).sd);
  double product = 0.0;
  const Moments m = moments(blocked);
  for (std::size_t i = 1; i < blocked.size(); ++i) {
    product += (blocked[i] - m.mean) * (blocked[i - 1] - m.mean);
  }
  EXPECT_GT(product / static_cast<double>(blocked.size()) / (m.sd * m.sd), 0.4);
}

TEST(UwbModel, lost_ranges_still_have_ground_truth) {
  UwbOptions o = UwbOptions::ideal();
  UwbModel model(o, 2, 1);
  EXPECT_FALSE(model.measure(kStart, end_at(0, {0, 0, 1}), end_at(1, {151, 0, 1}), open_air()));
  EXPECT_NEAR(model.last_truth().distance_m, 151.0, 1e-9);
  TriangleMesh rock;  // 10 m of it: 252 dB
  rock.add_box({10.0, 0.0, -5.0}, {10.0, 40.0, 10.0}, 0.0, 0.5);
  EXPECT_FALSE(model.measure(kStart, end_at(0, {0, 0, 1}), end_at(1, {20, 0, 1}), RayCaster(rock)));
  EXPECT_TRUE(model.last_truth().obstructed);
}

TEST(UwbModel, stamp_errors_are_offset_and_drift_of_the_measuring_vehicle) {
  UwbOptions o = UwbOptions::ideal();
  o.stamp_offset_s = 0.01;
  o.stamp_drift_ppm = 50.0;
  UwbModel model(o, 2, 9, kStart);
  const RadioEnd a = end_at(0, {0, 0, 1});
  const RadioEnd b = end_at(1, {5, 0, 1});
  const Time late = at_s(100.0);
  const double at_start = model.stamp_error_s(0, kStart);
  EXPECT_NE(at_start, model.stamp_error_s(1, kStart));
  EXPECT_LT(std::abs(model.stamp_error_s(0, late) - at_start), 100.0 * 50e-6 * 4.0);
  EXPECT_NE(model.stamp_error_s(0, late), at_start);
  const auto from_a = model.measure(late, a, b, open_air());
  const auto from_b = model.measure(late, b, a, open_air());
  ASSERT_TRUE(from_a && from_b);
  EXPECT_NEAR(seconds_between(late, from_a->t), model.stamp_error_s(0, late), 2e-9);
  EXPECT_NEAR(seconds_between(late, from_b->t), model.stamp_error_s(1, late), 2e-9);
}

TEST(UwbModel, a_third_vehicle_does_not_change_ranges_between_the_others) {
  const UwbOptions o;
  const RayCaster air = open_air();
  UwbModel two(o, 2, 11), three(o, 3, 11);
  const RadioEnd a = end_at(0, {0, 0, 1});
  const RadioEnd b = end_at(1, {7, 2, 1});
  const RadioEnd c = end_at(2, {3, 9, 1});
  for (int i = 0; i < 200; ++i) {
    const Time t = at_s(0.05 * i);
    const auto x = two.measure(t, a, b, air);
    (void)three.measure(t, a, c, air);
    const auto y = three.measure(t, a, b, air);
    (void)three.measure(t, b, c, air);
    ASSERT_EQ(x.has_value(), y.has_value());
    if (x) {
      ASSERT_EQ(x->range_m, y->range_m);
    }
    if (x) {
      ASSERT_EQ(x->t, y->t);
    }
  }
}

TEST(UwbModel, ranges_are_symmetric_in_both_directions) {
  UwbOptions o;
  o.stamp_offset_s = o.stamp_jitter_s = 0.0;
  const RayCaster air = open_air();
  UwbModel forth(o, 2, 12), back(o, 2, 12);
  const RadioEnd a = end_at(0, {0, 0, 1}, 0.4);
  const RadioEnd b = end_at(1, {7, 2, 1}, -1.0);
  EXPECT_EQ(forth.pair_bias_m(0, 0, 1, 0), forth.pair_bias_m(1, 0, 0, 0));
  for (int i = 0; i < 50; ++i) {
    const auto x = forth.measure(at_s(0.05 * i), a, b, air);
    const auto y = back.measure(at_s(0.05 * i), b, a, air);
    ASSERT_EQ(x.has_value(), y.has_value());
    if (x) {
      ASSERT_NEAR(x->range_m, y->range_m, 1.1e-3);
    }  // one step of the resolution
  }
}

TEST(UwbModel, multipath_error_is_constant_at_standstill_and_changes_over_0_5_m) {
  TriangleMesh mesh;
  mesh.add_box({0.0, 0.0, 0.0}, {60.0, 3.0, 2.8}, 0.0, 0.5);  // corridor, seen from inside
  const RayCaster corridor(mesh);
  UwbOptions o = UwbOptions::ideal();
  o.multipath_m = 0.05;
  o.reflection = 0.5;
  UwbModel model(o, 2, 1);
  const RadioEnd a = end_at(0, {-20, 0.3, 0.5});
  std::set<double> errors_m;
  for (int k = 0; k < 20; ++k) {
    const RadioEnd b = end_at(1, {0.5 * k, -0.4, 0.7});
    const auto first = errors(model, a, b, corridor, 3);
    ASSERT_EQ(first.size(), 3U);
    EXPECT_EQ(first[0], first[1]);
    EXPECT_EQ(first[0], first[2]);
    EXPECT_LT(std::abs(first[0]), 4 * 0.5 * 0.05 + 1e-9);
    errors_m.insert(first[0]);
  }
  EXPECT_GT(errors_m.size(), 15U);
  EXPECT_GT(*errors_m.rbegin() - *errors_m.begin(), 0.02);
}

}  // namespace
}  // namespace rali::sim
