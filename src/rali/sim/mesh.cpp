#include "rali/sim/mesh.hpp"

#include <cmath>
#include <numbers>

namespace rali::sim {

using geometry::Vec3;

std::uint32_t TriangleMesh::add_vertex(const Vec3& p) {
  vertices.push_back(p.cast<float>());
  return static_cast<std::uint32_t>(vertices.size() - 1);
}

void TriangleMesh::add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c, double refl) {
  triangles.push_back({a, b, c});
  reflectivity.push_back(static_cast<float>(refl));
}

void TriangleMesh::add_quad(const Vec3& corner, const Vec3& u, const Vec3& v, double refl) {
  const std::uint32_t a = add_vertex(corner);
  const std::uint32_t b = add_vertex(corner + u);
  const std::uint32_t c = add_vertex(corner + u + v);
  const std::uint32_t d = add_vertex(corner + v);
  add_triangle(a, b, c, refl);
  add_triangle(a, c, d, refl);
}

void TriangleMesh::add_box(const Vec3& base, const Vec3& size, double yaw_rad, double refl) {
  const Vec3 ex(std::cos(yaw_rad) * size.x(), std::sin(yaw_rad) * size.x(), 0.0);
  const Vec3 ey(-std::sin(yaw_rad) * size.y(), std::cos(yaw_rad) * size.y(), 0.0);
  const Vec3 ez(0.0, 0.0, size.z());
  const Vec3 corner = base - 0.5 * ex - 0.5 * ey;
  add_quad(corner, ex, ey, refl);
  add_quad(corner + ez, ex, ey, refl);
  add_quad(corner, ex, ez, refl);
  add_quad(corner + ey, ex, ez, refl);
  add_quad(corner, ey, ez, refl);
  add_quad(corner + ex, ey, ez, refl);
}

void TriangleMesh::add_cylinder(const Vec3& base, double radius_m, double height_m, int sides,
                                double refl) {
  const std::uint32_t top = add_vertex(base + Vec3(0.0, 0.0, height_m));
  const auto corner = [&](int i, double z) {
    const double angle = 2.0 * std::numbers::pi * i / sides;
    return add_vertex(base + Vec3(radius_m * std::cos(angle), radius_m * std::sin(angle), z));
  };
  std::uint32_t low = corner(0, 0.0);
  std::uint32_t high = corner(0, height_m);
  for (int i = 1; i <= sides; ++i) {
    const std::uint32_t next_low = corner(i, 0.0);
    const std::uint32_t next_high = corner(i, height_m);
    add_triangle(low, next_low, next_high, refl);
    add_triangle(low, next_high, high, refl);
    add_triangle(high, next_high, top, refl);
    low = next_low;
    high = next_high;
  }
}

Vec3 TriangleMesh::lower_corner() const {
  geometry::Vec3f low = geometry::Vec3f::Zero();
  if (!vertices.empty()) low = vertices.front();
  for (const geometry::Vec3f& v : vertices) low = low.cwiseMin(v);
  return low.cast<double>();
}

Vec3 TriangleMesh::upper_corner() const {
  geometry::Vec3f high = geometry::Vec3f::Zero();
  if (!vertices.empty()) high = vertices.front();
  for (const geometry::Vec3f& v : vertices) high = high.cwiseMax(v);
  return high.cast<double>();
}

namespace {

/// Value in [-1, 1] of one lattice point: a hash, so that no table is needed.
double lattice_value(std::int64_t i, std::int64_t j, std::int64_t k, std::uint64_t seed) {
  std::uint64_t h = seed;
  for (const std::int64_t index : {i, j, k}) {
    h += 0x9e3779b97f4a7c15ULL + static_cast<std::uint64_t>(index);
    h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ULL;
    h = (h ^ (h >> 27)) * 0x94d049bb133111ebULL;
    h ^= h >> 31;
  }
  return static_cast<double>(h >> 11) * (2.0 / 9007199254740992.0) - 1.0;
}

double smooth_step(double u) { return u * u * (3.0 - 2.0 * u); }

double value_noise(const Vec3& q, std::uint64_t seed) {
  const Vec3 cell(std::floor(q.x()), std::floor(q.y()), std::floor(q.z()));
  const Vec3 f = q - cell;
  const Vec3 w(smooth_step(f.x()), smooth_step(f.y()), smooth_step(f.z()));
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const int dx = corner & 1;
    const int dy = (corner >> 1) & 1;
    const int dz = (corner >> 2) & 1;
    const double weight =
        (dx ? w.x() : 1.0 - w.x()) * (dy ? w.y() : 1.0 - w.y()) * (dz ? w.z() : 1.0 - w.z());
    sum += weight * lattice_value(static_cast<std::int64_t>(cell.x()) + dx,
                                  static_cast<std::int64_t>(cell.y()) + dy,
                                  static_cast<std::int64_t>(cell.z()) + dz, seed);
  }
  return sum;
}

}  // namespace

double rock_noise(const Vec3& p, double size_m, std::uint64_t seed) {
  const Vec3 q = p / size_m;
  const double sum = value_noise(q, seed) + 0.5 * value_noise(2.1 * q, seed + 1) +
                     0.25 * value_noise(4.3 * q, seed + 2);
  return sum / 1.75;
}

}  // namespace rali::sim
