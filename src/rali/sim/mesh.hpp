#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "rali/geometry/types.hpp"

namespace rali::sim {

/// Triangles in the world frame (z up, metres), visible from both sides.
struct TriangleMesh {
  std::vector<geometry::Vec3f> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<float> reflectivity;  ///< per triangle, 0..1: fraction of light that is reflected

  std::uint32_t add_vertex(const geometry::Vec3& p);
  void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c, double refl);

  /// Flat parallelogram corner, corner + u, corner + u + v, corner + v.
  void add_quad(const geometry::Vec3& corner, const geometry::Vec3& u, const geometry::Vec3& v,
                double refl);
  /// Box on `base` (centre of its lower face), rotated by yaw; size = length, width, height.
  void add_box(const geometry::Vec3& base, const geometry::Vec3& size, double yaw_rad, double refl);
  /// Upright cylinder with `sides` flat faces, closed on top.
  void add_cylinder(const geometry::Vec3& base, double radius_m, double height_m, int sides,
                    double refl);

  [[nodiscard]] geometry::Vec3 lower_corner() const;
  [[nodiscard]] geometry::Vec3 upper_corner() const;
};

/// A smooth random function of position in [-1, 1] with features of about `size_m` (value noise
/// of three octaves). Same seed and position: same value, so adjacent surfaces stay joined.
[[nodiscard]] double rock_noise(const geometry::Vec3& p, double size_m, std::uint64_t seed);

}  // namespace rali::sim
