#pragma once

// Worlds of solid boxes for the tests of this module, seen by a spinning LiDAR.

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "rali/base/rng.hpp"
#include "rali/cloud/voxel_sampler.hpp"
#include "rali/places/submap.hpp"

namespace rali::places::test {

struct Box {
  geometry::Vec3 low_m, high_m;
};

using World = std::vector<Box>;

inline double range_m(const World& world, const geometry::Vec3& p, const geometry::Vec3& d) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Box& box : world) {
    double in = 0.0, out = nearest;
    for (int k = 0; k < 3; ++k) {
      const double a = (box.low_m[k] - p[k]) / d[k];
      const double b = (box.high_m[k] - p[k]) / d[k];
      in = std::max(in, std::min(a, b));
      out = std::min(out, std::max(a, b));
    }
    if (in < out && in > 0.0) nearest = in;
  }
  return nearest;
}

/// A round pipe along x, its bottom at z = 0.
struct Pipe {
  double radius_m = 1.5;
};

inline double range_m(const Pipe& pipe, const geometry::Vec3& p, const geometry::Vec3& d) {
  const double y = p.y(), z = p.z() - pipe.radius_m;
  const double a = d.y() * d.y() + d.z() * d.z();
  const double b = y * d.y() + z * d.z();
  const double c = y * y + z * z - pipe.radius_m * pipe.radius_m;
  return a > 1e-12 ? (-b + std::sqrt(b * b - a * c)) / a : std::numeric_limits<double>::infinity();
}

/// A passage along an arc that leaves the origin along x and turns left, floor at z = 0.
struct Bend {
  double radius_m = 40.0, half_width_m = 2.5, height_m = 4.0;
};

inline double range_m(const Bend& bend, const geometry::Vec3& p, const geometry::Vec3& d) {
  double nearest = (d.z() < 0.0 ? -p.z() : bend.height_m - p.z()) / d.z();
  const double x = p.x(), y = p.y() - bend.radius_m;
  const double a = d.x() * d.x() + d.y() * d.y();
  const double b = x * d.x() + y * d.y();
  for (const double side : {-1.0, 1.0}) {
    const double wall_m = bend.radius_m + side * bend.half_width_m;
    const double square = b * b - a * (x * x + y * y - wall_m * wall_m);
    if (square < 0.0) continue;
    const double t = (-b + side * std::sqrt(square)) / a;
    if (t > 0.0) nearest = std::min(nearest, t);
  }
  return nearest;
}

/// Floor, ceiling and four walls around [low, high].
inline void add_shell(World& w, const geometry::Vec3& low, const geometry::Vec3& high) {
  constexpr double t = 0.2;
  for (int k = 0; k < 3; ++k) {
    geometry::Vec3 a = low.array() - t, b = high.array() + t;
    b[k] = low[k];
    w.push_back({a, b});
    a = low.array() - t;
    b = high.array() + t;
    a[k] = high[k];
    w.push_back({a, b});
  }
}

/// 12 x 8 x 3 m with cupboards, a pillar, a bench: no symmetry.
inline World room() {
  World w;
  add_shell(w, {0.0, 0.0, 0.0}, {12.0, 8.0, 3.0});
  w.push_back({{0.0, 1.0, 0.0}, {0.8, 3.0, 2.2}});
  w.push_back({{7.0, 5.5, 0.0}, {7.6, 6.1, 3.0}});
  w.push_back({{9.0, 0.0, 0.0}, {11.0, 0.6, 0.9}});
  w.push_back({{4.0, 6.8, 0.0}, {5.2, 8.0, 1.8}});
  w.push_back({{2.5, 0.0, 0.0}, {3.0, 1.2, 2.0}});
  return w;
}

/// 2.4 m wide along x, [-half, half], door recesses 1 m wide and `deep_m` deep every `every_m` on
/// both sides. `closed` gives it end walls, `cupboard` an object that is in one place only.
struct CorridorOptions {
  double half_m = 60.0;
  double every_m = 5.0;
  double deep_m = 0.3;
  bool closed = false;
  bool cupboard = false;
};

inline World corridor(const CorridorOptions& o) {
  World w;
  const double outer = 1.2 + std::max(o.deep_m, 0.05);
  const double far = o.closed ? o.half_m : o.half_m + 200.0;
  add_shell(w, {-far, -outer, 0.0}, {far, outer, 2.6});
  if (o.every_m <= 0.0) return w;
  for (double x = -o.half_m; x < o.half_m; x += o.every_m) {
    for (const double side : {-1.0, 1.0}) {
      const double a = side < 0.0 ? -outer : 1.2;
      const double b = side < 0.0 ? -1.2 : outer;
      w.push_back({{x + 1.0, a, 0.0}, {x + o.every_m, b, 2.6}});
    }
  }
  if (o.cupboard) w.push_back({{2.5, 0.7, 0.0}, {3.3, 1.2, 1.8}});
  return w;
}

/// Smooth, without anything that distinguishes one place from the next.
inline World tunnel() {
  World w;
  add_shell(w, {-500.0, -2.5, 0.0}, {500.0, 2.5, 4.0});
  return w;
}

struct Sensor {
  int rings = 16;
  int columns = 600;
  double sigma_m = 0.02;
  double range_max_m = 50.0;
  double spacing_m = 0.2;
  double height_m = 0.6;  ///< of the LiDAR above the body's origin, which is on the floor
};

/// Owns the points of a Scan.
struct Scan {
  std::vector<float> x_m, y_m, z_m;
  geometry::SE3 T_world_body;

  [[nodiscard]] PosedScan posed(std::uint32_t seq, double height_m) const {
    PosedScan out;
    out.scan.id = {{0}, seq};
    out.scan.T_body_lidar.p.z() = height_m;
    out.scan.up_body = T_world_body.R.transpose() * geometry::Vec3::UnitZ();
    out.scan.x_m = x_m;
    out.scan.y_m = y_m;
    out.scan.z_m = z_m;
    out.T_odom_body = T_world_body;
    return out;
  }
};

template <class Place>
Scan look(const Place& world, const geometry::SE3& T_world_body, Rng& rng, const Sensor& s = {}) {
  std::vector<float> x, y, z;
  const double phase = rng.uniform(0.0, 0.01);
  for (int c = 0; c < s.columns; ++c) {
    const double azimuth = phase + 2.0 * std::numbers::pi * c / s.columns;
    for (int r = 0; r < s.rings; ++r) {
      const double elevation = (-15.0 + 30.0 * r / (s.rings - 1)) * std::numbers::pi / 180.0;
      const geometry::Vec3 d(std::cos(elevation) * std::cos(azimuth),
                             std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      const geometry::Vec3 o = T_world_body * geometry::Vec3(0.0, 0.0, s.height_m);
      const double range = range_m(world, o, T_world_body.R * d);
      if (!(range < s.range_max_m)) continue;
      const geometry::Vec3 p = (range + s.sigma_m * rng.normal()) * d;
      x.push_back(static_cast<float>(p.x()));
      y.push_back(static_cast<float>(p.y()));
      z.push_back(static_cast<float>(p.z()));
    }
  }
  std::vector<std::uint32_t> kept;
  cloud::VoxelSampler().sample_rays({x.data(), y.data(), z.data(), x.size()}, {}, s.spacing_m,
                                    kept);
  Scan out;
  out.T_world_body = T_world_body;
  for (const std::uint32_t i : kept) {
    out.x_m.push_back(x[i]);
    out.y_m.push_back(y[i]);
    out.z_m.push_back(z[i] + static_cast<float>(s.height_m));
  }
  return out;
}

inline geometry::SE3 at(double x, double y, double yaw_deg, double z = 0.0) {
  return {geometry::rotation_from_rpy(0.0, 0.0, yaw_deg * std::numbers::pi / 180.0), {x, y, z}};
}

/// Scans at the given poses as one submap around the middle one. @param jitter_m error of each pose
/// but the middle one, like that of an odometry.
template <class Place>
Submap map_of(const Place& world, const std::vector<geometry::SE3>& poses, Rng& rng,
              double jitter_m = 0.0, const Sensor& sensor = {},
              const SubmapSettings& settings = {}) {
  std::vector<Scan> scans;
  for (const geometry::SE3& T : poses) scans.push_back(look(world, T, rng, sensor));
  std::vector<PosedScan> posed;
  const std::size_t middle = poses.size() / 2;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    posed.push_back(scans[k].posed(static_cast<std::uint32_t>(k), sensor.height_m));
    if (k == middle) continue;
    for (int a = 0; a < 3; ++a) posed.back().T_odom_body.p[a] += jitter_m * rng.normal();
  }
  return make_submap(posed, middle, settings).value();
}

/// A straight path of n scans, 1 m apart, centred on a pose.
inline std::vector<geometry::SE3> path(const geometry::SE3& center, int n) {
  std::vector<geometry::SE3> out;
  for (int k = 0; k < n; ++k) {
    geometry::SE3 T = center;
    T.p += center.R.col(0) * (k - n / 2);
    out.push_back(T);
  }
  return out;
}

}  // namespace rali::places::test
