#include <cmath>
#include <numbers>

#include "rali/sim/builder.hpp"
#include "rali/sim/scenes/scenes.hpp"

namespace rali::sim::scenes {

using geometry::Vec3;

namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;

/// True if a disc does not touch the ring on which the vehicle drives.
bool clear_of_ring(const Vec3& centre, double radius_m, double ring_x_m, double ring_y_m) {
  const double scaled = std::hypot(centre.x() / ring_x_m, centre.y() / ring_y_m);
  return std::abs(scaled - 1.0) * std::min(ring_x_m, ring_y_m) > radius_m + 1.5;
}

void add_tree(Builder& build, const Vec3& base) {
  Rng& rng = build.rng();
  const double trunk = rng.uniform(1.8, 2.6);
  build.mesh().add_cylinder(base, rng.uniform(0.1, 0.2), trunk, 8, 0.3);
  for (int i = 0; i < 12; ++i) {  // crown: loose boxes
    const Vec3 at =
        base + Vec3(rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0), trunk + rng.uniform(-0.4, 1.6));
    build.mesh().add_box(at, {rng.uniform(0.2, 0.7), rng.uniform(0.2, 0.7), rng.uniform(0.1, 0.5)},
                         rng.uniform(0.0, kTwoPi), 0.4);
  }
}

void add_thing(Builder& build, const Vec3& base, double kind) {
  Rng& rng = build.rng();
  const double yaw = rng.uniform(0.0, kTwoPi);
  if (kind < 0.3) {  // shipping container
    build.mesh().add_box(base, {6.06, 2.44, 2.59}, yaw, rng.uniform(0.3, 0.6));
  } else if (kind < 0.5) {  // lamp post
    build.mesh().add_cylinder(base, 0.08, 6.0, 8, 0.5);
  } else if (kind < 0.75) {
    add_tree(build, base);
  } else {  // stack of pallets or a parked car: body and cabin
    build.mesh().add_box(base + Vec3(0.0, 0.0, 0.25), {4.3, 1.8, 0.65}, yaw, 0.5);
    build.mesh().add_box(base + Vec3(0.0, 0.0, 0.9), {2.2, 1.6, 0.55}, yaw, 0.3);
  }
}

void add_building(Builder& build, const Vec3& centre, const Vec3& size) {
  const double x = 0.5 * size.x();
  const double y = 0.5 * size.y();
  const std::array<Vec3, 4> corners{centre + Vec3(-x, -y, 0.0), centre + Vec3(x, -y, 0.0),
                                    centre + Vec3(x, y, 0.0), centre + Vec3(-x, y, 0.0)};
  // Visible from outside: corners in reverse order.
  for (std::size_t i = 0; i < 4; ++i) {
    build.lived_in_wall(corners[(i + 1) % 4], corners[i], size.z(), 4.0, 0.0);
  }
  build.slab(centre.x() - x, centre.y() - y, centre.x() + x, centre.y() + y, size.z());
}

/// Rolling ground: cells of 1 m, bumps of a few centimetres.
void add_ground(Builder& build, double half_x, double half_y, std::uint64_t seed) {
  build.rough_quad({-half_x, -half_y, 0.0}, {2.0 * half_x, 0.0, 0.0}, {0.0, 2.0 * half_y, 0.0}, 1.0,
                   0.06, 9.0, seed, 0.3);
}

}  // namespace

World yard(Rng rng) {
  World world;
  Builder build(world.mesh, rng);
  constexpr double kHalfX_m = 38.0;
  constexpr double kHalfY_m = 30.0;
  const double ring_x = rng.uniform(17.0, 20.0);
  const double ring_y = rng.uniform(12.0, 14.0);
  add_ground(build, kHalfX_m, kHalfY_m, rng.next());
  for (const double side : {-1.0, 1.0}) {  // fence, 1.8 m
    build.mesh().add_quad({-kHalfX_m, side * kHalfY_m, -0.1}, {2.0 * kHalfX_m, 0.0, 0.0},
                          {0.0, 0.0, 1.9}, 0.3);
    build.mesh().add_quad({side * kHalfX_m, -kHalfY_m, -0.1}, {0.0, 2.0 * kHalfY_m, 0.0},
                          {0.0, 0.0, 1.9}, 0.3);
  }
  add_building(build, {rng.uniform(-4.0, 4.0), rng.uniform(-2.0, 2.0), -0.1},
               {rng.uniform(8.0, 14.0), rng.uniform(6.0, 9.0), rng.uniform(4.0, 8.0)});
  add_building(build, {rng.uniform(-28.0, -26.0), rng.uniform(-18.0, 18.0), -0.1},
               {rng.uniform(6.0, 9.0), 12.0, 6.0});
  for (int placed = 0, tries = 0; placed < 26 && tries < 1000; ++tries) {
    const Vec3 at(rng.uniform(-34.0, 34.0), rng.uniform(-26.0, 26.0), -0.05);
    const double kind = rng.uniform();
    if (!clear_of_ring(at, 3.3, ring_x, ring_y)) continue;
    add_thing(build, at, kind);
    ++placed;
  }
  for (int i = 0; i <= 26; ++i) {
    const double angle = kTwoPi * i / 24.0 - 0.5 * std::numbers::pi;
    world.route.emplace_back(ring_x * std::cos(angle), ring_y * std::sin(angle), 0.0);
  }
  world.rounding_m = 3.0;
  world.free_width_m = 1.2;
  return world;
}

World garage(Rng rng) {
  World world;
  Builder build(world.mesh, rng);
  constexpr double kX_m = 60.0;
  constexpr double kY_m = 40.0;
  const double height = rng.uniform(2.5, 3.0);
  const double pillar = rng.uniform(0.4, 0.6);
  build.wall({0, 0, 0}, {kX_m, 0, 0}, height, {});
  build.wall({kX_m, 0, 0}, {kX_m, kY_m, 0}, height, {{20.0, 3.0, 0.0, 2.2, 0.4, 0.5, false}});
  build.wall({kX_m, kY_m, 0}, {0, kY_m, 0}, height, {});
  build.wall({0, kY_m, 0}, {0, 0, 0}, height, {{12.0, 1.0, 0.0, 2.1, 0.1, 0.5, false}});
  build.slab(0, 0, kX_m, kY_m, 0.0);
  build.slab(0, 0, kX_m, kY_m, height, 0.6);
  for (int i = 1; i <= 6; ++i) {
    for (int j = 1; j <= 4; ++j) {
      build.mesh().add_box({i * 8.0 + 2.0, j * 8.0, 0.0}, {pillar, pillar, height}, 0.0, 0.6);
    }
  }
  const int cars = static_cast<int>(rng.below(5)) + 3;
  for (int i = 0; i < cars; ++i) {  // along the long walls only
    const Vec3 at(6.0 + 2.7 * static_cast<double>(rng.below(18)), rng.uniform() < 0.5 ? 2.6 : 37.4,
                  0.0);
    build.mesh().add_box(at + Vec3(0, 0, 0.25), {1.8, 4.3, 0.65}, 0.0, rng.uniform(0.1, 0.7));
    build.mesh().add_box(at + Vec3(0, 0, 0.9), {1.6, 2.2, 0.55}, 0.0, 0.3);
  }
  world.route = {{6, 12, 0}, {54, 12, 0}, {54, 28, 0}, {14, 28, 0}, {14, 20, 0}, {46, 20, 0}};
  world.rounding_m = 2.0;
  world.free_width_m = 1.6;
  return world;
}

}  // namespace rali::sim::scenes
