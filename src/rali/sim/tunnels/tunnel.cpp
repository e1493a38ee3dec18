#include <cmath>

#include <fmt/core.h>

#include "rali/sim/tunnels/tube.hpp"
#include "rali/sim/tunnels/tunnels.hpp"

namespace rali::sim {

using geometry::Vec3;

namespace {

constexpr double kLead_m = 4.0;  ///< of tunnel behind the start and beyond the end

/// Points of the axis every metre; the first lies kLead_m behind the origin.
std::vector<Vec3> axis_points(const TunnelOptions& o) {
  const int n = static_cast<int>(std::ceil(o.length_m));
  std::vector<Vec3> points;
  for (int i = 0; i <= n; ++i) {
    const double s = o.length_m * i / n - kLead_m;
    const double k = o.curvature_per_m;
    const double z = o.gradient * s;
    if (std::abs(k) < 1e-9) {
      points.emplace_back(s, 0.0, z);
    } else {
      points.emplace_back(std::sin(k * s) / k, (1.0 - std::cos(k * s)) / k, z);
    }
  }
  return points;
}

/// Depth of the niche at this point of the wall.
double niche_depth(const TubePoint& q, double every_m) {
  constexpr double kHalf_m = 1.0;
  constexpr double kTop_m = 2.0;
  constexpr double kDepth_m = 0.7;
  if (every_m <= 0.0 || q.floor || q.up_m > kTop_m) return 0.0;
  const double number = std::round(q.along_m / every_m);
  if (number < 1.0 || std::abs(q.along_m - number * every_m) > kHalf_m) return 0.0;
  const bool left = static_cast<long>(number) % 2 == 0;
  return left == (q.left_m > 0.0) ? kDepth_m : 0.0;
}

}  // namespace

Result<World> tunnel_world(const TunnelOptions& o, Rng rng) {
  constexpr double kTurnMost_rad = 5.5;
  const double turn = std::abs(o.curvature_per_m) * o.length_m;
  const double radius = turn > 0.0 ? o.length_m / turn : 1e9;
  if (turn > kTurnMost_rad || radius < o.width_m) {
    return fail(ErrorCode::kUsage, "tunnel",
                fmt::format("with a radius of {:.1f} m the tunnel runs into itself", radius),
                "Make it shorter or less bent, or use a ramp.");
  }
  World world;
  Builder build(world.mesh, rng);
  const std::uint64_t seed = rng.next();
  const Route axis(axis_points(o), 2.0);
  const double half = 0.5 * o.width_m;
  const double cell = o.niche_every_m > 0.0 ? 0.4 : 0.8;
  add_tube(build.mesh(), axis, {half, o.wall_height_m}, cell, 40, o.reflectivity,
           [&](const TubePoint& q) {
             const double rough = q.floor ? 0.0 : o.roughness_m * rock_noise(q.p, 1.2, seed);
             return rough + niche_depth(q, o.niche_every_m);
           });
  if (o.closed_ends) {
    const double size = half + o.wall_height_m + 0.5;
    add_tube_end(build, axis.point_at(0.0), axis.yaw_at(0.0), size, seed, 0.0);
    add_tube_end(build, axis.point_at(1e9), axis.yaw_at(1e9), size, seed, 0.0);
  }
  const int n = std::max(1, static_cast<int>((o.length_m - 2.0 * kLead_m) / 2.0));
  for (int i = 0; i <= n; ++i) {
    world.route.push_back(axis.point_at(kLead_m + (axis.length_m() - 2.0 * kLead_m) * i / n));
  }
  world.rounding_m = 4.0;
  world.free_width_m = std::max(0.0, half - 0.7 - o.roughness_m);
  return world;
}

}  // namespace rali::sim
