#pragma once

// A small world for the tests of this module: an empty box with upright cylinders in it, seen by a
// spinning LiDAR of 16 rings. Exact rays, no noise.

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "rali/map/keyframe_view.hpp"

namespace rali::map::test {

struct Cylinder {
  double x_m, y_m, radius_m, height_m;
};

/// A thin wall along x, from the floor to the ceiling.
struct Partition {
  double x_low_m, x_high_m, y_m;
};

struct Room {
  geometry::Vec3 low_m{0.0, 0.0, 0.0}, high_m{20.0, 10.0, 3.0};
  std::vector<Cylinder> cylinders;
  std::vector<Partition> partitions = {};
};

/// Owns what a KeyframeView points to.
struct Scan {
  Time t;
  geometry::SE3 T_map_body;
  geometry::Mat6 covariance = geometry::Mat6::Zero();
  std::vector<float> x_m, y_m, z_m, intensity;
  std::vector<std::uint16_t> ring;

  void add(double x, double y, double z, std::uint16_t r = 0, float i = 0.0F) {
    x_m.push_back(static_cast<float>(x));
    y_m.push_back(static_cast<float>(y));
    z_m.push_back(static_cast<float>(z));
    intensity.push_back(i);
    ring.push_back(r);
  }

  [[nodiscard]] KeyframeView view() const {
    KeyframeView v;
    v.t = t;
    v.T_map_body = T_map_body;
    v.covariance = covariance;
    v.x_m = x_m;
    v.y_m = y_m;
    v.z_m = z_m;
    v.intensity = intensity;
    v.ring = ring;
    return v;
  }
};

inline double distance_to_walls(const Room& room, const geometry::Vec3& p,
                                const geometry::Vec3& d) {
  double nearest = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    if (d(k) > 0.0) nearest = std::min(nearest, (room.high_m(k) - p(k)) / d(k));
    if (d(k) < 0.0) nearest = std::min(nearest, (room.low_m(k) - p(k)) / d(k));
  }
  return nearest;
}

inline double distance_to_cylinder(const Cylinder& c, const geometry::Vec3& p,
                                   const geometry::Vec3& d) {
  const geometry::Vec2 q = p.head<2>() - geometry::Vec2{c.x_m, c.y_m};
  const double a = d.head<2>().squaredNorm(), b = q.dot(d.head<2>());
  const double disc = b * b - a * (q.squaredNorm() - c.radius_m * c.radius_m);
  if (disc < 0.0) return std::numeric_limits<double>::infinity();
  const double s = (-b - std::sqrt(disc)) / a;
  const double z = p.z() + s * d.z();
  return s > 0.0 && z <= c.height_m ? s : std::numeric_limits<double>::infinity();
}

inline double distance_to_partition(const Partition& w, const geometry::Vec3& p,
                                    const geometry::Vec3& d) {
  const double s = (w.y_m - p.y()) / d.y();
  const double x = p.x() + s * d.x();
  return s > 0.0 && x >= w.x_low_m && x <= w.x_high_m ? s : std::numeric_limits<double>::infinity();
}

/// One scan from a pose; rings at -15, -13, ... +15 degrees, `columns` per turn.
inline Scan look_around(const Room& room, const geometry::SE3& T_map_body, double t_s,
                        int columns = 1800) {
  Scan out;
  out.t = Time::from_s(t_s);
  out.T_map_body = T_map_body;
  for (int i = 0; i < columns; ++i) {
    const double azimuth = 2.0 * std::numbers::pi * i / columns;
    for (int ring = 0; ring < 16; ++ring) {
      const double elevation = (-15.0 + 2.0 * ring) * std::numbers::pi / 180.0;
      const geometry::Vec3 d{std::cos(elevation) * std::cos(azimuth),
                             std::cos(elevation) * std::sin(azimuth), std::sin(elevation)};
      const geometry::Vec3 d_map = T_map_body.R * d;
      double range = distance_to_walls(room, T_map_body.p, d_map);
      for (const Cylinder& c : room.cylinders) {
        range = std::min(range, distance_to_cylinder(c, T_map_body.p, d_map));
      }
      for (const Partition& w : room.partitions) {
        range = std::min(range, distance_to_partition(w, T_map_body.p, d_map));
      }
      const geometry::Vec3 p = range * d;
      out.add(p.x(), p.y(), p.z(), static_cast<std::uint16_t>(ring), 10.0F);
    }
  }
  return out;
}

inline geometry::SE3 pose_at(double x, double y, double z, double yaw_rad = 0.0) {
  return {geometry::rotation_from_rpy(0.0, 0.0, yaw_rad), {x, y, z}};
}

}  // namespace rali::map::test
