#include "rali/sim/tunnels/tube.hpp"

#include <cmath>
#include <numbers>

namespace rali::sim {

using geometry::Vec3;

namespace {

constexpr double kPi = std::numbers::pi;

/// A point of a cross-section: left (towards +left) and up from the middle of the floor.
struct SectionPoint {
  double left_m, up_m;
};

/// u in [0, 1] runs once around, floor first.
SectionPoint section(double u, const ArchShape& shape) {
  const double half_m = shape.half_width_m;
  const double wall_m = shape.wall_m;
  if (shape.round) {
    const double angle = 2.0 * kPi * u;
    return {half_m * std::sin(angle), half_m * (1.0 - std::cos(angle))};
  }
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

}  // namespace

void add_tube(TriangleMesh& mesh, const Route& axis, const ArchShape& shape, double cell_m,
              int around, double refl, const TubeShift& shift) {
  const double center_m = shape.round ? shape.half_width_m : shape.wall_m;
  const int rows = std::max(1, static_cast<int>(std::ceil(axis.length_m() / cell_m)));
  const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
  for (int j = 0; j <= rows; ++j) {
    const double s = axis.length_m() * j / rows;
    const Vec3 middle = axis.point_at(s);
    const double yaw = axis.yaw_at(s);
    const Vec3 left(-std::sin(yaw), std::cos(yaw), 0.0);
    for (int i = 0; i < around; ++i) {
      const SectionPoint q = section(static_cast<double>(i) / around, shape);
      const Vec3 p = middle + q.left_m * left + Vec3(0.0, 0.0, q.up_m);
      const Vec3 outward = (q.left_m * left + Vec3(0.0, 0.0, q.up_m - center_m)).normalized();
      const bool floor = !shape.round && q.up_m <= 0.0;
      mesh.add_vertex(p + shift({p, s, q.left_m, q.up_m, floor}) *
                              (floor ? Vec3(0.0, 0.0, -1.0) : outward));
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

void add_tube_end(Builder& build, const Vec3& middle, double yaw_rad, double size_m,
                  std::uint64_t seed, double amplitude_m) {
  const Vec3 left(-std::sin(yaw_rad), std::cos(yaw_rad), 0.0);
  build.rough_quad(middle - size_m * left - Vec3(0.0, 0.0, 0.5), 2.0 * size_m * left,
                   Vec3(0.0, 0.0, 2.0 * size_m), 0.5, amplitude_m, 1.5, seed, 0.4);
}

}  // namespace rali::sim
