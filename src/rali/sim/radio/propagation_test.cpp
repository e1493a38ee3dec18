#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "rali/sim/radio/places_for_test.hpp"

namespace rali::sim {
namespace {

TEST(Propagation, ten_times_the_distance_costs_ten_times_the_exponent_in_dB) {
  EXPECT_NEAR(path_loss_db(1.0, 2.0), 0.0, 1e-12);
  EXPECT_NEAR(path_loss_db(10.0, 2.0), 20.0, 1e-12);
  EXPECT_NEAR(path_loss_db(10.0, 3.0), 30.0, 1e-12);
}

TEST(Propagation, reported_power_saturates) {
  EXPECT_NEAR(reported_power_dbm(-90.0, -90.0), -93.0103, 1e-4);  // half of each
  EXPECT_NEAR(reported_power_dbm(-40.0, -78.0), -78.0, 1e-3);
  EXPECT_NEAR(reported_power_dbm(-120.0, -78.0), -120.0, 1e-3);
}

TEST(Propagation, packet_loss_is_50_percent_at_the_sensitivity) {
  EXPECT_NEAR(loss_probability(-98.0, -98.0), 0.5, 1e-12);
  EXPECT_NEAR(loss_probability(-96.0, -98.0), 1.0 / (1.0 + std::exp(2.0)), 1e-12);
  EXPECT_LT(loss_probability(-60.0, -98.0), 1e-15);
}

TEST(Propagation, one_ground_reflection_gives_the_expected_range_error_and_power) {
  TriangleMesh mesh;
  mesh.add_box({0.0, 0.0, -1.0}, {100.0, 100.0, 1.0}, 0.0, 0.5);  // ground at z = 0
  const RayCaster ground(mesh);
  MultipathOptions o;
  o.error_m = 0.1;
  o.pulse_m = 0.3;
  o.reflection = 0.5;
  o.wavelength_m = 0.1;
  // 8 m apart, 3 m high: the reflected path is hypot(8, 6) = 10 m long, 2 m or 20 wavelengths more.
  // With its phase reversed it opposes the direct path with amplitude 0.5 * 8 / 10.
  const Multipath m = multipath_between(ground, {-4.0, 0.0, 3.0}, {4.0, 0.0, 3.0}, o);
  EXPECT_NEAR(m.range_error_m, -0.1 * 0.4 * std::exp(-2.0 / 0.3), 1e-7);
  EXPECT_NEAR(m.power_db, 20.0 * std::log10(0.6), 1e-3);
}

TEST(Propagation, wandering_has_unit_sigma_and_the_set_correlation_time) {
  Wandering value;
  Rng rng(3, "wandering");
  std::vector<double> all;
  for (int i = 0; i < 40000; ++i) all.push_back(value.next(at_s(0.5 * i), 1.0, rng));
  EXPECT_NEAR(moments(all).sd, 1.0, 0.05);
  double product = 0.0;
  for (std::size_t i = 1; i < all.size(); ++i) product += all[i] * all[i - 1];
  EXPECT_NEAR(product / static_cast<double>(all.size()), std::exp(-0.5), 0.05);
}

TEST(Propagation, bursts_have_the_set_fraction_and_duration_at_any_rate) {
  for (const double step_s : {0.02, 0.3}) {
    Burst burst;
    Rng rng(5, "burst");
    int on = 0, began = 0;
    const int steps = 200000;
    for (int i = 0; i < steps; ++i) {
      on += burst.next(at_s(step_s * i), 0.2, 1.5, rng) ? 1 : 0;
      began += burst.began() ? 1 : 0;
    }
    EXPECT_NEAR(on / static_cast<double>(steps), 0.2, 0.025) << step_s;
    // Sampled at steps, bursts appear slightly longer than their mean: short gaps are missed.
    EXPECT_NEAR(step_s * on / began, 1.5, 0.35) << step_s;
  }
}

TEST(Obstruction, is_zero_in_open_air_and_the_crossed_thickness_in_walls) {
  const Obstruction open = trace_line(open_air(), {0, 0, 1}, {10, 0, 1}, 0.1);
  EXPECT_TRUE(open.clear());
  const Obstruction wall = trace_line(one_wall(), {0, 0, 1}, {10, 0, 1}, 0.1);
  EXPECT_EQ(wall.walls, 1);
  EXPECT_NEAR(wall.thickness_m, 0.2, 1e-5);
  // At 60 deg to the normal the crossed thickness doubles.
  const double along = 10.0 * std::tan(M_PI / 3.0);
  const Obstruction askew = trace_line(one_wall(), {0, 0, 1}, {10, along, 1}, 0.1);
  EXPECT_EQ(askew.walls, 1);
  EXPECT_NEAR(askew.thickness_m, 0.4, 1e-4);
}

TEST(Obstruction, a_wall_beyond_the_other_antenna_is_not_crossed) {
  EXPECT_TRUE(trace_line(one_wall(), {0, 0, 1}, {4.8, 0, 1}, 0.1).clear());
}

TEST(Obstruction, single_surfaces_have_the_given_thickness) {
  TriangleMesh mesh;
  mesh.add_quad({5, -9, -9}, {0, 18, 0}, {0, 0, 18}, 0.5);
  const Obstruction sheet = trace_line(RayCaster(mesh), {0, 0, 1}, {10, 0, 1}, 0.15);
  EXPECT_EQ(sheet.walls, 1);
  EXPECT_DOUBLE_EQ(sheet.thickness_m, 0.15);
}

TEST(Obstruction, the_space_between_a_wall_and_a_sheet_is_not_counted) {
  TriangleMesh mesh;
  mesh.add_box({5.0, 0.0, -5.0}, {0.2, 40.0, 10.0}, 0.0, 0.5);
  mesh.add_quad({8, -9, -9}, {0, 18, 0}, {0, 0, 18}, 0.5);
  const Obstruction both = trace_line(RayCaster(mesh), {0, 0, 1}, {10, 0, 1}, 0.15);
  EXPECT_EQ(both.walls, 2);
  EXPECT_NEAR(both.thickness_m, 0.35, 1e-5);
}

TEST(Obstruction, bodies_obstruct_only_between_antennas_and_below_their_height) {
  const std::vector<RadioBody> body{{{5.0, 0.2, 0.0}, 0.3, 1.7}};
  const RayCaster air = open_air();
  EXPECT_EQ(trace_line(air, {0, 0, 1}, {10, 0, 1}, 0.1, body).bodies, 1);
  EXPECT_EQ(trace_line(air, {0, 0, 2}, {10, 0, 2}, 0.1, body).bodies, 0);
  EXPECT_EQ(trace_line(air, {0, 0, 1}, {4, 0, 1}, 0.1, body).bodies, 0);
  EXPECT_EQ(trace_line(air, {0, 0.6, 1}, {10, 0.6, 1}, 0.1, body).bodies, 0);
}

TEST(Obstruction, coincident_or_nan_endpoints_give_no_obstruction) {
  EXPECT_TRUE(trace_line(one_wall(), {1, 1, 1}, {1, 1, 1}, 0.1).clear());
  const double nan = std::nan("");
  EXPECT_TRUE(trace_line(one_wall(), {nan, 0, 0}, {1, 1, 1}, 0.1).clear());
}

}  // namespace
}  // namespace rali::sim
