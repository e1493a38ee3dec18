#pragma once

#include <cstdint>
#include <memory>

#include "rali/eval/mesh.hpp"

namespace rali::eval {

/// The point of a triangle nearest to p; exact for degenerate triangles (zero area) too.
[[nodiscard]] geometry::Vec3 closest_on_triangle(const geometry::Vec3& p, const geometry::Vec3& a,
                                                 const geometry::Vec3& b, const geometry::Vec3& c);

/// Finds the triangle nearest to a point by Embree's point query. Embree's tree has single
/// precision and only proposes triangles, with a margin for its rounding; distances have double
/// precision. Of equally near triangles the first in the mesh is returned: results do not depend on
/// the tree or the processor. Queries are thread-safe.
class TriangleTree {
 public:
  /// @param mesh must have passed check_mesh()
  explicit TriangleTree(const TriangleMesh& mesh);
  ~TriangleTree();
  TriangleTree(const TriangleTree&) = delete;
  TriangleTree& operator=(const TriangleTree&) = delete;

  struct Nearest {
    double distance_m = 0.0;
    geometry::Vec3 point = geometry::Vec3::Zero();  ///< on the triangle
    std::uint32_t triangle = 0;                     ///< index in the mesh
  };

  /// @param p finite
  [[nodiscard]] Nearest nearest(const geometry::Vec3& p) const;

  /// Unit normal of a triangle of the mesh; zero if it has no area.
  [[nodiscard]] geometry::Vec3 normal(std::uint32_t triangle) const;

 private:
  struct Impl;
  std::unique_ptr<const Impl> impl_;
};

}  // namespace rali::eval
