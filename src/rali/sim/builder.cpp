#include "rali/sim/builder.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace rali::sim {

using geometry::Vec3;

namespace {

Vec3 up(double height_m) { return {0.0, 0.0, height_m}; }

}  // namespace

void Builder::wall(const Vec3& a, const Vec3& b, double height_m,
                   const std::vector<WallFeature>& features, double refl) {
  const double length = (b - a).norm();
  if (length <= 0.0) return;
  const Vec3 e = (b - a) / length;
  const Vec3 behind(e.y(), -e.x(), 0.0);
  double done = 0.0;
  for (const WallFeature& f : features) {
    const double begin = std::max(done, f.at_m - 0.5 * f.width_m);
    const double end = std::min(length, f.at_m + 0.5 * f.width_m);
    if (end - begin < 0.05) continue;
    const Vec3 left = a + begin * e;
    const Vec3 across = (end - begin) * e;
    mesh_.add_quad(a + done * e, (begin - done) * e, up(height_m), refl);
    if (f.bottom_m > 0.0) mesh_.add_quad(left, across, up(f.bottom_m), refl);
    mesh_.add_quad(left + up(f.top_m), across, up(height_m - f.top_m), refl);
    const Vec3 inward = f.depth_m * behind;
    const double tall = f.top_m - f.bottom_m;
    if (!f.open) mesh_.add_quad(left + up(f.bottom_m) + inward, across, up(tall), f.refl);
    mesh_.add_quad(left + up(f.bottom_m), inward, up(tall), refl);
    mesh_.add_quad(left + up(f.bottom_m) + across, inward, up(tall), refl);
    mesh_.add_quad(left + up(f.top_m), inward, across, refl);
    // The floors on both sides end at the wall's faces: without this quad the floor of a door has a
    // gap.
    if (f.bottom_m > 0.0 || f.open) mesh_.add_quad(left + up(f.bottom_m), inward, across, refl);
    done = end;
  }
  mesh_.add_quad(a + done * e, (length - done) * e, up(height_m), refl);
}

void Builder::lived_in_wall(const Vec3& a, const Vec3& b, double height_m, double spacing_m,
                            double room_depth_m) {
  const double length = (b - a).norm();
  const Vec3 e = (b - a) / std::max(length, 1e-9);
  const Vec3 behind(e.y(), -e.x(), 0.0);
  std::vector<WallFeature> features;
  for (double s = rng_.uniform(0.4, 0.7) * spacing_m; s < length - 1.5;
       s += spacing_m * rng_.uniform(0.8, 1.2)) {
    WallFeature f;
    f.at_m = s;
    const double kind = rng_.uniform();
    if (kind < 0.4 && room_depth_m > 0.0 && s > room_depth_m && s < length - room_depth_m) {
      // The margin keeps rooms behind two walls of one corner from overlapping.
      f.open = true;
      f.depth_m = 0.15;
      const double width = std::min(0.75 * spacing_m, 5.0);
      room_behind(a + s * e + 0.15 * behind, e, behind, width,
                  room_depth_m * rng_.uniform(0.7, 1.0), height_m, f.width_m);
    } else if (kind < 0.75) {  // closed door
      f.depth_m = rng_.uniform(0.05, 0.12);
      f.refl = rng_.uniform(0.3, 0.8);
    } else if (kind < 0.9) {  // cabinet or radiator
      f.width_m = rng_.uniform(0.6, 1.4);
      f.bottom_m = 0.1;
      f.top_m = rng_.uniform(0.7, 1.9);
      f.depth_m = -rng_.uniform(0.08, 0.3);
    } else {  // pilaster
      f.width_m = rng_.uniform(0.3, 0.5);
      f.top_m = height_m;
      f.depth_m = -rng_.uniform(0.1, 0.25);
    }
    features.push_back(f);
  }
  wall(a, b, height_m, features, rng_.uniform(0.5, 0.7));
}

void Builder::room_behind(const Vec3& door, const Vec3& along, const Vec3& behind, double width_m,
                          double depth_m, double height_m, double door_width_m) {
  const Vec3 corner = door - 0.5 * width_m * along;
  const Vec3 far = corner + depth_m * behind;
  const double side = 0.5 * (width_m - door_width_m);
  mesh_.add_quad(corner, side * along, up(height_m), 0.6);
  mesh_.add_quad(corner + (width_m - side) * along, side * along, up(height_m), 0.6);
  mesh_.add_quad(door - 0.5 * door_width_m * along + up(2.1), door_width_m * along,
                 up(height_m - 2.1), 0.6);
  mesh_.add_quad(far, width_m * along, up(height_m), 0.6);
  mesh_.add_quad(corner, depth_m * behind, up(height_m), 0.6);
  mesh_.add_quad(corner + width_m * along, depth_m * behind, up(height_m), 0.6);
  mesh_.add_quad(corner, width_m * along, depth_m * behind, 0.4);
  mesh_.add_quad(corner + up(height_m), width_m * along, depth_m * behind, 0.7);
  furnish(corner + 0.3 * depth_m * behind, width_m * along, 0.7 * depth_m * behind, 4);
}

void Builder::slab(double x0, double y0, double x1, double y1, double z, double refl) {
  mesh_.add_quad({x0, y0, z}, {x1 - x0, 0.0, 0.0}, {0.0, y1 - y0, 0.0}, refl);
}

void Builder::rough_quad(const Vec3& corner, const Vec3& u, const Vec3& v, double cell_m,
                         double amplitude_m, double grain_m, std::uint64_t seed, double refl) {
  const Vec3 normal = u.cross(v).normalized();
  const int nu = std::max(1, static_cast<int>(std::ceil(u.norm() / cell_m)));
  const int nv = std::max(1, static_cast<int>(std::ceil(v.norm() / cell_m)));
  const auto base = static_cast<std::uint32_t>(mesh_.vertices.size());
  for (int j = 0; j <= nv; ++j) {
    for (int i = 0; i <= nu; ++i) {
      const Vec3 p = corner + u * (static_cast<double>(i) / nu) + v * (static_cast<double>(j) / nv);
      mesh_.add_vertex(p + amplitude_m * rock_noise(p, grain_m, seed) * normal);
    }
  }
  const auto row = static_cast<std::uint32_t>(nu + 1);
  for (std::uint32_t j = 0; j < static_cast<std::uint32_t>(nv); ++j) {
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(nu); ++i) {
      const std::uint32_t k = base + j * row + i;
      mesh_.add_triangle(k, k + 1, k + row + 1, refl);
      mesh_.add_triangle(k, k + row + 1, k + row, refl);
    }
  }
}

void Builder::furnish(const Vec3& corner, const Vec3& u, const Vec3& v, int pieces) {
  const double yaw = std::atan2(u.y(), u.x());
  for (int i = 0; i < pieces; ++i) {
    const Vec3 base = corner + rng_.uniform(0.15, 0.85) * u + rng_.uniform(0.15, 0.85) * v;
    const double tall = rng_.uniform() < 0.4 ? rng_.uniform(1.5, 2.0) : rng_.uniform(0.4, 1.1);
    mesh_.add_box(base, {rng_.uniform(0.5, 1.5), rng_.uniform(0.4, 0.8), tall},
                  yaw + rng_.uniform(-0.2, 0.2), rng_.uniform(0.2, 0.8));
  }
}

}  // namespace rali::sim
