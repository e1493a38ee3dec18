#include <cmath>
#include <numbers>

#include "rali/sim/tunnels/drift.hpp"
#include "rali/sim/tunnels/tube.hpp"
#include "rali/sim/tunnels/tunnels.hpp"

namespace rali::sim {

using geometry::Vec3;

namespace {

/// Props, rubble and a cart: clutter in a drift.
void add_clutter(Builder& build, const Route& axis, const DriftShape& shape) {
  Rng& rng = build.rng();
  const double wall = shape.arch.half_width_m;
  for (double s = 6.0; s < axis.length_m() - 5.0;
       s += shape.clutter_every_m * rng.uniform(4.0 / 6.5, 9.0 / 6.5)) {
    const double yaw = axis.yaw_at(s);
    const Vec3 left(-std::sin(yaw), std::cos(yaw), 0.0);
    const double side = rng.uniform() < 0.5 ? -1.0 : 1.0;
    const double from_axis = rng.uniform(wall - 0.6, wall - 0.3);
    const Vec3 at = axis.point_at(s) + side * from_axis * left - Vec3(0.0, 0.0, 0.1);
    if (rng.uniform() < 0.5) {
      build.mesh().add_cylinder(at, 0.1, 2.6, 8, 0.3);
    } else {
      build.mesh().add_box(at,
                           {rng.uniform(0.4, 1.2), rng.uniform(0.3, 0.5), rng.uniform(0.3, 0.8)},
                           rng.uniform(0.0, 6.0), 0.3);
    }
  }
}

}  // namespace

World drift_world(const Route& axis, const DriftShape& shape, std::uint64_t seed, Rng& rng) {
  World world;
  Builder build(world.mesh, rng);
  const auto rock = [&](const TubePoint& q) {
    return q.floor ? 0.05 * rock_noise(q.p, 2.5, seed + 9)
                   : shape.roughness_m * rock_noise(q.p, 1.6, seed) +
                         0.2 * shape.roughness_m * rock_noise(q.p, 0.4, seed + 5);
  };
  add_tube(build.mesh(), axis, shape.arch, 0.35, 44, 0.25, rock);
  const double size = shape.arch.half_width_m + 2.3;
  add_tube_end(build, axis.point_at(0.0), axis.yaw_at(0.0), size, seed, shape.roughness_m);
  add_tube_end(build, axis.point_at(1e9), axis.yaw_at(1e9), size, seed, shape.roughness_m);
  if (shape.clutter_every_m > 0.0) add_clutter(build, axis, shape);
  for (double s = 4.0; s < axis.length_m() - 4.0; s += 3.0) world.route.push_back(axis.point_at(s));
  world.rounding_m = 2.0;
  world.free_width_m = shape.arch.half_width_m - 1.1;
  return world;
}

World mine_world(const MineOptions& o, Rng rng) {
  constexpr double kPiece_m = 25.0;
  constexpr double kDegree = std::numbers::pi / 180.0;
  const std::uint64_t seed = rng.next();
  // Headings stay within 70 deg of the first, so that the drift never intersects itself.
  const double heading_max = 70.0 * kDegree;
  std::vector<Vec3> corners{{-4.0, 0.0, 0.0}};
  double heading = 0.0;
  for (double left_m = o.length_m; left_m > 0.0; left_m -= kPiece_m) {
    const double piece = left_m < 1.5 * kPiece_m ? left_m : kPiece_m;
    corners.push_back(corners.back() +
                      piece * Vec3(std::cos(heading), std::sin(heading), o.gradient));
    if (piece > kPiece_m || piece == left_m) break;
    heading += rng.uniform(-o.bend_deg, o.bend_deg) * kDegree;
    heading = std::clamp(heading, -heading_max, heading_max);
  }
  const Route axis(corners, 5.0);
  return drift_world(axis, {{0.5 * o.width_m, o.wall_height_m}, o.roughness_m, o.clutter_every_m},
                     seed, rng);
}

}  // namespace rali::sim
