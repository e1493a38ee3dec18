#include <cmath>
#include <functional>
#include <numbers>

#include "rali/sim/builder.hpp"
#include "rali/sim/route.hpp"
#include "rali/sim/scenes/scenes.hpp"

namespace rali::sim::scenes {

using geometry::Vec3;

namespace {

constexpr double kPi = std::numbers::pi;

/// A point of a cross-section: left (towards +left) and up from the middle of the floor.
struct SectionPoint {
  double left_m, up_m;
};

/// Arch over a flat floor of 2 half_m width; u in [0, 1] runs once around, floor first.
SectionPoint arch(double u, double half_m, double wall_m) {
  const double floor = 2.0 * half_m;
  const double dome = kPi * half_m;
  double s = u * (floor + 2.0 * wall_m + dome);
  if (s < floor) return {half_m - s, 0.0};
  s -= floor;
  if (s < wall_m) return {-half_m, s};
  s -= wall_m;
  if (s < dome) return {-half_m * std::cos(s / half_m), wall_m + half_m * std::sin(s / half_m)};
  return {half_m, wall_m - (s - dome)};
}

using Shift = std::function<double(const Vec3& p, bool floor)>;  ///< outward displacement [m]

/// Sweeps the arch along a route; `shift` roughens it.
void add_tube(TriangleMesh& mesh, const Route& route, double half_m, double wall_m, double cell_m,
              int around, double refl, const Shift& shift) {
  const int rows = static_cast<int>(std::ceil(route.length_m() / cell_m));
  const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
  for (int j = 0; j <= rows; ++j) {
    const double s = route.length_m() * j / rows;
    const Vec3 middle = route.point_at(s);
    const double yaw = route.yaw_at(s);
    const Vec3 left(-std::sin(yaw), std::cos(yaw), 0.0);
    for (int i = 0; i < around; ++i) {
      const SectionPoint q = arch(static_cast<double>(i) / around, half_m, wall_m);
      const Vec3 p = middle + q.left_m * left + Vec3(0.0, 0.0, q.up_m);
      const Vec3 outward = (q.left_m * left + Vec3(0.0, 0.0, q.up_m - wall_m)).normalized();
      const bool floor = q.up_m <= 0.0;
      mesh.add_vertex(p + shift(p, floor) * (floor ? Vec3(0.0, 0.0, -1.0) : outward));
    }
  }
  const auto n = static_cast<std::uint32_t>(around);
  for (std::uint32_t j = 0; j < static_cast<std::uint32_t>(rows); ++j) {
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t a = base + j * n + i;
      const std::uint32_t b = base + j * n + (i + 1) % n;
      mesh.add_triangle(a, b, b + n, refl);
      mesh.add_triangle(a, b + n, a + n, refl);
    }
  }
}

/// Closes a tube: a wall across its end.
void add_end(Builder& build, const Vec3& middle, double yaw_rad, double size_m, std::uint64_t seed,
             double amplitude_m) {
  const Vec3 left(-std::sin(yaw_rad), std::cos(yaw_rad), 0.0);
  build.rough_quad(middle - size_m * left - Vec3(0.0, 0.0, 0.5), 2.0 * size_m * left,
                   Vec3(0.0, 0.0, 2.0 * size_m), 0.5, amplitude_m, 1.5, seed, 0.4);
}

}  // namespace

World tunnel(Rng rng) {
  World world;
  Builder build(world.mesh, rng);
  const double bend = (rng.uniform() < 0.5 ? -1.0 : 1.0) * rng.uniform(8.0, 14.0);
  const Route axis({{-4, 0, 0}, {70, 0, 0}, {135, 0.6 * bend, 0}, {196, 2.0 * bend, 0}}, 25.0);
  const double half = rng.uniform(2.2, 2.8);
  const std::uint64_t seed = rng.next();
  // Shotcrete: a few millimetres.
  add_tube(build.mesh(), axis, half, 1.2, 0.8, 40, 0.4, [&](const Vec3& p, bool floor) {
    return floor ? 0.0 : 0.008 * rock_noise(p, 1.2, seed);
  });
  add_end(build, axis.point_at(0.0), axis.yaw_at(0.0), 4.5, seed, 0.0);
  add_end(build, axis.point_at(1e9), axis.yaw_at(1e9), 4.5, seed, 0.0);
  // Boxes of lamps and cables about every 25 m, on alternating sides.
  double side = 1.0;
  for (double s = rng.uniform(8.0, 14.0); s < axis.length_m() - 3.0; s += rng.uniform(18.0, 32.0)) {
    const double yaw = axis.yaw_at(s);
    const Vec3 left(-std::sin(yaw), std::cos(yaw), 0.0);
    build.mesh().add_box(axis.point_at(s) + side * (half - 0.1) * left + Vec3(0.0, 0.0, 0.9),
                         {rng.uniform(0.4, 0.9), 0.3, rng.uniform(0.4, 0.8)}, yaw, 0.6);
    side = -side;
  }
  for (double s = 4.0; s < axis.length_m() - 4.0; s += 4.0) world.route.push_back(axis.point_at(s));
  world.rounding_m = 4.0;
  world.free_width_m = half - 0.7;
  return world;
}

World mine(Rng rng) {
  World world;
  Builder build(world.mesh, rng);
  const double turn = rng.uniform() < 0.5 ? -1.0 : 1.0;
  const std::uint64_t seed = rng.next();
  const double height = rng.uniform(0.8, 1.4);
  const auto rock = [&](const Vec3& p, bool floor) {
    return floor ? 0.05 * rock_noise(p, 2.5, seed + 9)
                 : 0.30 * rock_noise(p, 1.6, seed) + 0.06 * rock_noise(p, 0.4, seed + 5);
  };
  const Route drift({{-4, 0, 0},
                     {30, 4 * turn, 0},
                     {48, 22 * turn, 0},
                     {74, 26 * turn, 0.6},
                     {100, 14 * turn, 1.2}},
                    8.0);
  add_tube(build.mesh(), drift, 2.2, height, 0.35, 44, 0.25, rock);
  add_end(build, drift.point_at(0.0), drift.yaw_at(0.0), 4.5, seed, 0.3);
  add_end(build, drift.point_at(1e9), drift.yaw_at(1e9), 4.5, seed, 0.3);
  // Props, rubble and a cart: what stands about in a drift.
  for (double s = 6.0; s < drift.length_m() - 5.0; s += rng.uniform(4.0, 9.0)) {
    const double yaw = drift.yaw_at(s);
    const Vec3 left(-std::sin(yaw), std::cos(yaw), 0.0);
    const double side = rng.uniform() < 0.5 ? -1.0 : 1.0;
    const Vec3 at = drift.point_at(s) + side * rng.uniform(1.6, 1.9) * left - Vec3(0.0, 0.0, 0.1);
    if (rng.uniform() < 0.5) {
      build.mesh().add_cylinder(at, 0.1, 2.6, 8, 0.3);
    } else {
      build.mesh().add_box(at,
                           {rng.uniform(0.4, 1.2), rng.uniform(0.3, 0.5), rng.uniform(0.3, 0.8)},
                           rng.uniform(0.0, 6.0), 0.3);
    }
  }
  for (double s = 4.0; s < drift.length_m() - 4.0; s += 3.0)
    world.route.push_back(drift.point_at(s));
  world.rounding_m = 2.0;
  world.free_width_m = 1.1;
  return world;
}

World ramp(Rng rng) {
  World world;
  Builder build(world.mesh, rng);
  const double radius = rng.uniform(8.0, 10.0);
  const double rise = rng.uniform(2.8, 3.2);  // per turn
  constexpr double kHalf_m = 2.1;
  constexpr double kTurns = 2.0;
  constexpr int kPerTurn = 48;
  constexpr double kWall_m = 2.15;  // low enough for the turn above and the halls
  const auto ground = [&](double turns, double r) {
    const double angle = 2.0 * kPi * turns - 0.5 * kPi;
    return Vec3(r * std::cos(angle), r * std::sin(angle), rise * turns);
  };
  for (int i = 0; i < static_cast<int>(kTurns * kPerTurn); ++i) {
    const double a = static_cast<double>(i) / kPerTurn;
    const double b = static_cast<double>(i + 1) / kPerTurn;
    TriangleMesh& mesh = build.mesh();
    for (const double lift : {0.0, kWall_m}) {  // floor and ceiling
      const std::uint32_t p = mesh.add_vertex(ground(a, radius - kHalf_m) + Vec3(0, 0, lift));
      const std::uint32_t q = mesh.add_vertex(ground(a, radius + kHalf_m) + Vec3(0, 0, lift));
      const std::uint32_t r = mesh.add_vertex(ground(b, radius + kHalf_m) + Vec3(0, 0, lift));
      const std::uint32_t s = mesh.add_vertex(ground(b, radius - kHalf_m) + Vec3(0, 0, lift));
      mesh.add_triangle(p, q, r, 0.4);
      mesh.add_triangle(p, r, s, 0.4);
    }
    for (const double r : {radius - kHalf_m, radius + kHalf_m}) {  // walls
      mesh.add_quad(ground(a, r), ground(b, r) - ground(a, r), {0.0, 0.0, kWall_m}, 0.6);
    }
    if (i % 6 == 0) mesh.add_cylinder(ground(a, radius + kHalf_m - 0.15), 0.12, kWall_m, 8, 0.5);
  }
  // Level halls below and above, each a box open towards the ramp.
  const double top = rise * kTurns;
  for (const double z : {0.0, top}) {
    const double x0 = z > 0.0 ? 0.0 : -14.0;
    const double x1 = z > 0.0 ? 14.0 : 0.0;
    const double y0 = -radius - 6.0;
    const double y1 = -radius + 6.0;
    build.slab(x0, y0, x1, y1, z);
    build.slab(x0, y0, x1, y1, z + kWall_m, 0.7);
    build.lived_in_wall({x0, y0, z}, {x1, y0, z}, kWall_m, 4.0, 0.0);
    build.lived_in_wall({x1, y1, z}, {x0, y1, z}, kWall_m, 4.0, 0.0);
    build.lived_in_wall({z > 0.0 ? x1 : x0, z > 0.0 ? y0 : y1, z},
                        {z > 0.0 ? x1 : x0, z > 0.0 ? y1 : y0, z}, kWall_m, 4.0, 0.0);
    build.furnish({x0 + (z > 0.0 ? 8.0 : 1.0), y0 + 0.5, z}, {5.0, 0.0, 0.0}, {0.0, 2.0, 0.0}, 4);
  }
  world.route.emplace_back(-11.0, -radius, 0.0);
  for (int i = 0; i <= static_cast<int>(kTurns * 24); ++i)
    world.route.push_back(ground(i / 24.0, radius));
  world.route.emplace_back(11.0, -radius, top);
  world.rounding_m = 2.0;
  world.free_width_m = 1.2;
  return world;
}

}  // namespace rali::sim::scenes
