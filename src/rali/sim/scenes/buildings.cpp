#include <cmath>
#include <numbers>

#include "rali/sim/builder.hpp"
#include "rali/sim/scenes/scenes.hpp"

namespace rali::sim::scenes {

using geometry::Vec3;

World loop(Rng rng) {
  World world;
  Builder build(world.mesh, rng);
  // Centre lines of the corridors enclose `length` x `width`; their sum fixes the path at 160 m.
  const double length = rng.uniform(46.0, 52.0);
  const double width = 80.0 - length;
  const double half = 0.5 * rng.uniform(2.4, 3.0);
  const double height = rng.uniform(2.6, 3.0);
  const auto corners = [&](double grow) {
    return std::array<Vec3, 4>{Vec3(-grow, -grow, 0.0), Vec3(length + grow, -grow, 0.0),
                               Vec3(length + grow, width + grow, 0.0),
                               Vec3(-grow, width + grow, 0.0)};
  };
  const std::array<Vec3, 4> outer = corners(half);
  const std::array<Vec3, 4> inner = corners(-half);
  for (std::size_t i = 0; i < 4; ++i) {
    build.lived_in_wall(outer[i], outer[(i + 1) % 4], height, 5.5, 5.0);
    build.lived_in_wall(inner[(i + 1) % 4], inner[i], height, 6.5, 5.0);
  }
  const double edge = half;
  build.slab(-edge, -edge, length + edge, width + edge, 0.0);
  build.slab(-edge, -edge, length + edge, width + edge, height, 0.7);
  const double start = 0.5 * length;
  world.route = {{start, 0.0, 0.0}, {length, 0.0, 0.0}, {length, width, 0.0},
                 {0.0, width, 0.0}, {0.0, 0.0, 0.0},    {start + 7.0, 0.0, 0.0}};
  world.free_width_m = half - 0.5;
  return world;
}

World corridor(Rng rng) {
  World world;
  Builder build(world.mesh, rng);
  const double first = rng.uniform(42.0, 50.0);
  const double second = 84.0 - first;
  const double turn =
      (rng.uniform() < 0.5 ? -1.0 : 1.0) * rng.uniform(70.0, 100.0) * std::numbers::pi / 180.0;
  constexpr double kHalf_m = 1.2;
  const double height = rng.uniform(2.5, 2.9);
  const Vec3 e1(1.0, 0.0, 0.0);
  const Vec3 e2(std::cos(turn), std::sin(turn), 0.0);
  const Vec3 n1(0.0, 1.0, 0.0);
  const Vec3 n2(-e2.y(), e2.x(), 0.0);
  const Vec3 start = -2.0 * e1;
  const Vec3 bend = first * e1;
  const Vec3 end = bend + (second + 2.0) * e2;
  // Mitre of the two walls at the bend.
  const Vec3 mitre = (n1 + n2) / (1.0 + n1.dot(n2));
  const Vec3 left = bend + kHalf_m * mitre;
  const Vec3 right = bend - kHalf_m * mitre;
  build.lived_in_wall(left, start + kHalf_m * n1, height, 9.0, 0.0);
  build.lived_in_wall(end + kHalf_m * n2, left, height, 9.0, 0.0);
  build.lived_in_wall(start - kHalf_m * n1, right, height, 9.0, 0.0);
  build.lived_in_wall(right, end - kHalf_m * n2, height, 9.0, 0.0);
  build.wall(start + kHalf_m * n1, start - kHalf_m * n1, height, {});
  build.wall(end - kHalf_m * n2, end + kHalf_m * n2, height,
             {{1.2, 0.9, 0.0, 2.1, 0.08, 0.5, false}});
  const Vec3 low = world.mesh.lower_corner();
  const Vec3 high = world.mesh.upper_corner();
  build.slab(low.x(), low.y(), high.x(), high.y(), 0.0);
  build.slab(low.x(), low.y(), high.x(), high.y(), height, 0.7);
  world.route = {Vec3::Zero(), bend, bend + second * e2 - 1.5 * e2};
  world.free_width_m = 0.7;
  return world;
}

World storey(Rng rng) {
  World world;
  Builder build(world.mesh, rng);
  // Hall [0, hall_x] x [0, hall_y]. A corridor leaves it eastwards at y = door and meets a crossing
  // corridor at x = cross. That one leads north to a third, which returns west above the hall.
  const double hall_x = rng.uniform(13.0, 16.0);
  const double hall_y = rng.uniform(10.0, 12.0);
  const double door = 0.5 * hall_y;
  const double half = rng.uniform(1.0, 1.3);
  const double cross = hall_x + rng.uniform(17.0, 20.0);
  const double north = hall_y + rng.uniform(7.0, 9.0);
  const double south = -rng.uniform(5.0, 7.0);
  const double high = rng.uniform(2.7, 3.2);
  const WallFeature opening{0.0, 2.0 * half, 0.0, 2.3, 0.02, 0.5, true};
  const auto gate = [&](double at) {
    WallFeature f = opening;
    f.at_m = at;
    return f;
  };
  build.lived_in_wall({0, 0, 0}, {hall_x, 0, 0}, high, 4.0, 4.0);
  build.wall({hall_x, 0, 0}, {hall_x, hall_y, 0}, high, {gate(door)});
  build.lived_in_wall({hall_x, hall_y, 0}, {0, hall_y, 0}, high, 4.0, 3.0);
  build.lived_in_wall({0, hall_y, 0}, {0, 0, 0}, high, 3.5, 0.0);
  for (const double x : {0.33, 0.67}) {  // pillars of the hall
    build.mesh().add_cylinder({x * hall_x, 0.25 * hall_y, 0.0}, 0.25, high, 16, 0.6);
    build.mesh().add_cylinder({x * hall_x, 0.75 * hall_y, 0.0}, 0.25, high, 16, 0.6);
  }
  build.furnish({1.0, 0.72 * hall_y, 0.0}, {hall_x - 2.0, 0.0, 0.0}, {0.0, 0.22 * hall_y, 0.0}, 4);
  const double west = 2.0;
  build.lived_in_wall({hall_x, door - half, 0}, {cross - half, door - half, 0}, high, 5.0, 4.0);
  build.lived_in_wall({cross - half, door + half, 0}, {hall_x, door + half, 0}, high, 5.0, 3.0);
  build.lived_in_wall({cross - half, door - half, 0}, {cross - half, south, 0}, high, 4.0, 0.0);
  build.wall({cross - half, south, 0}, {cross + half, south, 0}, high, {});
  build.lived_in_wall({cross + half, south, 0}, {cross + half, north + half, 0}, high, 5.0, 4.0);
  build.lived_in_wall({cross + half, north + half, 0}, {west, north + half, 0}, high, 5.5, 4.0);
  build.wall({west, north + half, 0}, {west, north - half, 0}, high, {});
  build.lived_in_wall({west, north - half, 0}, {cross - half, north - half, 0}, high, 6.0, 0.0);
  build.lived_in_wall({cross - half, north - half, 0}, {cross - half, door + half, 0}, high, 4.0,
                      0.0);
  build.slab(0, south, cross + half, north + half, 0.0);
  build.slab(0, south, cross + half, north + half, high, 0.7);
  world.route = {{0.85 * hall_x, 0.12 * hall_y, 0.0},
                 {0.15 * hall_x, 0.12 * hall_y, 0.0},
                 {0.15 * hall_x, door, 0.0},
                 {cross, door, 0.0},
                 {cross, north, 0.0}};
  // The rest of 93 m goes west.
  double path = 0.0;
  for (std::size_t i = 1; i < world.route.size(); ++i)
    path += (world.route[i] - world.route[i - 1]).norm();
  world.route.emplace_back(std::max(west + 1.2, cross - (93.0 - path)), north, 0.0);
  world.free_width_m = half - 0.4;
  return world;
}

}  // namespace rali::sim::scenes
