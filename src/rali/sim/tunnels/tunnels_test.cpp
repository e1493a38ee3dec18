#include "rali/sim/tunnels/tunnels.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/sim/ray_caster.hpp"
#include "rali/sim/route.hpp"

namespace rali::sim {
namespace {

using geometry::Vec3;

TEST(Tunnel, cross_section_has_floor_walls_and_a_semicircular_arch) {
  TunnelOptions o;
  o.length_m = 40.0;
  o.width_m = 5.0;
  o.wall_height_m = 1.2;
  o.roughness_m = 0.0;
  const World world = tunnel_world(o, Rng(1, "test")).value();
  const RayCaster caster(world.mesh);
  // From the centre of the circle all rays into the arch are one radius long; the polygon of 40
  // chords is at most 7 mm smaller.
  const Vec3 middle(15.0, 0.0, 1.2);
  for (double angle = 0.05; angle < 3.1; angle += 0.1) {
    const Hit hit = caster.cast(middle, {0.0, std::cos(angle), std::sin(angle)}, 10.0);
    EXPECT_NEAR(hit.range_m, 2.5, 0.02) << angle;
  }
  EXPECT_NEAR(caster.cast(middle, -Vec3::UnitZ(), 10.0).range_m, 1.2, 1e-4);
  EXPECT_NEAR(caster.cast({15.0, 0.0, 0.6}, Vec3::UnitY(), 10.0).range_m, 2.5, 0.02);
  // Open ends: nothing along the axis.
  EXPECT_EQ(caster.cast(middle, Vec3::UnitX(), 1000.0).range_m, 0.0F);
  EXPECT_EQ(caster.cast(middle, -Vec3::UnitX(), 1000.0).range_m, 0.0F);
}

TEST(Tunnel, a_round_pipe_has_the_same_radius_in_all_directions) {
  TunnelOptions o;
  o.length_m = 40.0;
  o.width_m = 5.0;
  o.round = true;
  o.roughness_m = 0.0;
  const World world = tunnel_world(o, Rng(1, "test")).value();
  const RayCaster caster(world.mesh);
  for (double angle = 0.05; angle < 6.2; angle += 0.1) {
    const Hit hit = caster.cast({15.0, 0.0, 2.5}, {0.0, std::cos(angle), std::sin(angle)}, 10.0);
    EXPECT_NEAR(hit.range_m, 2.5, 0.001) << angle;
  }
}

TEST(Tunnel, a_round_pipe_with_niches_or_cabinets_is_refused) {
  TunnelOptions o;
  o.round = true;
  EXPECT_TRUE(tunnel_world(o, Rng(1, "test")));
  o.niche_every_m = 20.0;
  EXPECT_FALSE(tunnel_world(o, Rng(1, "test")));
  o.niche_every_m = 0.0;
  o.cabinet_every_m = 20.0;
  EXPECT_FALSE(tunnel_world(o, Rng(1, "test")));
}

TEST(Tunnel, length_curvature_and_gradient_match_the_options) {
  TunnelOptions o;
  o.length_m = 300.0;
  o.curvature_per_m = 0.005;  // radius 200 m
  o.gradient = 0.05;
  const World world = tunnel_world(o, Rng(1, "test")).value();
  const Route route(world.route, world.rounding_m);
  EXPECT_NEAR(route.length_m(), 292.0, 1.0);
  EXPECT_NEAR(route.curvature_at(150.0), 0.005, 2e-4);
  EXPECT_NEAR(route.slope_at(150.0), 0.05, 1e-3);
  const Vec3 end = route.point_at(1e9);
  EXPECT_NEAR(end.x(), 200.0 * std::sin(292.0 / 200.0), 0.5);
  EXPECT_NEAR(end.y(), 200.0 * (1.0 - std::cos(292.0 / 200.0)), 0.5);
}

TEST(Tunnel, niches_are_at_the_set_spacing) {
  TunnelOptions o;
  o.length_m = 60.0;
  o.roughness_m = 0.0;
  o.niche_every_m = 20.0;
  const World world = tunnel_world(o, Rng(1, "test")).value();
  const RayCaster caster(world.mesh);
  const auto width_at = [&](double x) {
    return caster.cast({x, 0.0, 0.6}, Vec3::UnitY(), 10.0).range_m +
           caster.cast({x, 0.0, 0.6}, -Vec3::UnitY(), 10.0).range_m;
  };
  EXPECT_GT(width_at(20.0 - 4.0), 5.5F);  // the axis begins 4 m behind the origin
  EXPECT_NEAR(width_at(10.0), 5.0F, 0.03);
}

TEST(Tunnel, segments_have_curvature_and_gradient_within_the_set_limits) {
  TunnelOptions o;
  o.length_m = 600.0;
  o.segment_m = 80.0;
  o.segment_curvature_per_m = 1.0 / 260.0;
  o.segment_gradient = 0.035;
  const World world = tunnel_world(o, Rng(4, "test")).value();
  const Route route(world.route, world.rounding_m);
  EXPECT_NEAR(route.length_m(), 592.0, 4.0);
  double bend = 0.0;
  double rise = 0.0;
  for (double s = 5.0; s < 585.0; s += 1.0) {
    bend = std::max(bend, std::abs(route.curvature_at(s)));
    rise = std::max(rise, std::abs(route.slope_at(s)));
  }
  EXPECT_LT(bend, 1.1 / 260.0);
  EXPECT_GT(bend, 0.4 / 260.0);
  EXPECT_LT(rise, 0.036);
  EXPECT_GT(rise, 0.012);
}

TEST(Tunnel, cabinets_are_at_the_walls_and_keep_the_lane_free) {
  TunnelOptions o;
  o.length_m = 200.0;
  o.roughness_m = 0.0;
  o.cabinet_every_m = 20.0;
  const World world = tunnel_world(o, Rng(2, "test")).value();
  const RayCaster caster(world.mesh);
  int narrow = 0;
  for (double x = 0.0; x < 190.0; x += 0.1) {
    for (const double side : {-1.0, 1.0}) {
      const float range_m = caster.cast({x, 0.0, 0.6}, {0.0, side, 0.0}, 10.0).range_m;
      EXPECT_GT(range_m, 2.0F);
      narrow += range_m < 2.3F ? 1 : 0;
    }
  }
  EXPECT_GT(narrow, 9 * 5);  // nine cabinets or so, none narrower than half a metre
}

TEST(Tunnel, self_intersecting_tunnels_are_refused) {
  TunnelOptions o;
  o.length_m = 700.0;
  o.curvature_per_m = 0.01;
  const auto world = tunnel_world(o, Rng(1, "test"));
  ASSERT_FALSE(world);
  EXPECT_NE(world.error().what.find("radius of 100.0 m"), std::string::npos);
}

TEST(Ramp, height_gain_is_turns_times_rise) {
  RampOptions o;
  o.turns = 3;
  o.rise_m = 3.5;
  const World world = ramp_world(o, Rng(1, "test")).value();
  EXPECT_NEAR(world.route.back().z() - world.route.front().z(), 10.5, 1e-9);
  // Along the lane: 3 turns of 2 pi 9 m, and 11 m of hall at both ends.
  EXPECT_NEAR(Route(world.route, world.rounding_m).length_m(), 3.0 * 56.55 + 22.0, 4.0);
}

TEST(Ramp, overlapping_turns_are_refused) {
  RampOptions o;
  o.height_m = 2.9;
  ASSERT_FALSE(ramp_world(o, Rng(1, "test")));
}

TEST(Mine, walls_are_rough_and_the_mean_width_is_near_the_option) {
  MineOptions o;
  o.width_m = 6.0;
  const World world = mine_world(o, Rng(3, "test"));
  const RayCaster caster(world.mesh);
  const Route route(world.route, world.rounding_m);
  EXPECT_NEAR(route.length_m(), 102.0, 6.0);
  double sum = 0.0;
  double squares = 0.0;
  int n = 0;
  for (double s = 10.0; s < 90.0; s += 1.0, ++n) {
    const double yaw = route.yaw_at(s);
    const Vec3 left(-std::sin(yaw), std::cos(yaw), 0.0);
    const Vec3 p = route.point_at(s) + Vec3(0.0, 0.0, 1.0);
    const double width = static_cast<double>(caster.cast(p, left, 20.0).range_m) +
                         static_cast<double>(caster.cast(p, -left, 20.0).range_m);
    sum += width;
    squares += width * width;
  }
  const double mean = sum / n;
  EXPECT_NEAR(mean, 6.0, 0.4);
  EXPECT_GT(std::sqrt(squares / n - mean * mean), 0.08);
}

}  // namespace
}  // namespace rali::sim
