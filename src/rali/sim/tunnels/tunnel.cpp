#include <cmath>

#include <fmt/core.h>

#include "rali/sim/tunnels/tube.hpp"
#include "rali/sim/tunnels/tunnels.hpp"

namespace rali::sim {

using geometry::Vec3;

namespace {

constexpr double kLead_m = 4.0;  ///< of tunnel behind the start and beyond the end

/// Curvature and gradient of one segment of the axis.
struct Piece {
  double end_m, curvature_per_m, gradient;
};

std::vector<Piece> draw_pieces(const TunnelOptions& o, Rng& rng) {
  std::vector<Piece> pieces;
  for (double s = 0.0; s < o.length_m;) {
    s += o.segment_m * rng.uniform(0.5, 1.5);
    const double curvature = o.curvature_per_m + o.segment_curvature_per_m * rng.uniform(-1.0, 1.0);
    pieces.push_back({s, curvature, o.gradient + o.segment_gradient * rng.uniform(-1.0, 1.0)});
  }
  return pieces;
}

/// Points every metre along segments; curvature and gradient change over kBlend_m, as on roads.
std::vector<Vec3> axis_of_pieces(const TunnelOptions& o, Rng& rng) {
  constexpr double kBlend_m = 12.0;
  const std::vector<Piece> pieces = draw_pieces(o, rng);
  std::vector<Vec3> points{Vec3(-kLead_m, 0.0, 0.0)};
  double yaw = 0.0;
  double curvature = 0.0;
  double gradient = 0.0;
  std::size_t k = 0;
  for (double s = 1.0; s <= o.length_m; s += 1.0) {
    while (k + 1 < pieces.size() && pieces[k].end_m < s) ++k;
    curvature += (pieces[k].curvature_per_m - curvature) / kBlend_m;
    gradient += (pieces[k].gradient - gradient) / kBlend_m;
    // The start is straight and level, so that vehicles begin at the origin along x.
    if (s <= 2.0 * kLead_m) curvature = gradient = 0.0;
    yaw += curvature;
    points.push_back(points.back() + Vec3(std::cos(yaw), std::sin(yaw), gradient));
  }
  return points;
}

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

/// Depth of the niche at this point of the wall, 0 if none.
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

/// Switch cabinets and similar boxes at either wall.
void add_cabinets(const TunnelOptions& o, const Route& axis, Builder& build) {
  constexpr double kHeight_m = 1.1;
  if (o.cabinet_every_m <= 0.0) return;
  Rng& rng = build.rng();
  double s = 0.5 * o.cabinet_every_m;
  for (; s < axis.length_m() - kLead_m; s += o.cabinet_every_m * rng.uniform(0.8, 1.2)) {
    const double yaw = axis.yaw_at(s);
    const double side = rng.uniform() < 0.5 ? -1.0 : 1.0;
    const Vec3 along(std::cos(yaw), std::sin(yaw), 0.0);
    const Vec3 outward = side * Vec3(-std::sin(yaw), std::cos(yaw), 0.0);
    const double width = rng.uniform(0.6, 1.2);
    const double depth = rng.uniform(0.25, 0.45);
    const double inside = 0.5 * o.width_m - depth;
    const Vec3 foot = axis.point_at(s) + inside * outward - 0.5 * width * along;
    const Vec3 up(0.0, 0.0, kHeight_m);
    const auto face = [&](const Vec3& corner, const Vec3& u, const Vec3& v) {
      build.rough_quad(corner, u, v, 2.0, 0.0, 1.0, 0, 0.5);
    };
    face(foot, width * along, up);
    face(foot, depth * outward, up);
    face(foot + width * along, depth * outward, up);
    face(foot + up, width * along, depth * outward);
  }
}

}  // namespace

Result<World> tunnel_world(const TunnelOptions& o, Rng rng) {
  constexpr double kTurnMax_rad = 5.5;
  const double bend =
      std::abs(o.curvature_per_m) + (o.segment_m > 0.0 ? o.segment_curvature_per_m : 0.0);
  const double turn = bend * o.length_m;
  const double radius = turn > 0.0 ? o.length_m / turn : 1e9;
  if (turn > kTurnMax_rad || radius < o.width_m) {
    return fail(ErrorCode::kUsage, "tunnel",
                fmt::format("with a radius of {:.1f} m the tunnel runs into itself", radius),
                "Make it shorter or less bent, or use a ramp.");
  }
  if (o.round && (o.niche_every_m > 0.0 || o.cabinet_every_m > 0.0)) {
    return fail(ErrorCode::kUsage, "tunnel", "a round pipe has no walls for niches and cabinets",
                "Leave out niche_every_m and cabinet_every_m, or round.");
  }
  World world;
  Builder build(world.mesh, rng);
  const std::uint64_t seed = rng.next();
  const Route axis(o.segment_m > 0.0 ? axis_of_pieces(o, rng) : axis_points(o), 2.0);
  const double half = 0.5 * o.width_m;
  const double cell = o.niche_every_m > 0.0 ? 0.4 : 0.8;
  // So many that the chords of the circle are within 1 mm of a pipe of 5 m: an edge seen by a LiDAR
  // would give it the roll.
  const int around = o.round ? 240 : 40;
  add_tube(build.mesh(), axis, {half, o.wall_height_m, o.round}, cell, around, o.reflectivity,
           [&](const TubePoint& q) {
             const double rough = q.floor ? 0.0 : o.roughness_m * rock_noise(q.p, 1.2, seed);
             return rough + niche_depth(q, o.niche_every_m);
           });
  add_cabinets(o, axis, build);
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
  // A vehicle beside the lowest line of a pipe leans: 17 degrees at this distance.
  constexpr double kBesideLowest = 0.3;
  world.free_width_m = o.round ? kBesideLowest * half : std::max(0.0, half - 0.7 - o.roughness_m);
  return world;
}

}  // namespace rali::sim
