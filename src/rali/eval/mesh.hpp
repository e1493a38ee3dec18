#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/geometry/types.hpp"

namespace rali::eval {

/// Surfaces of the true world [m]; the orientation of triangles is ignored.
struct TriangleMesh {
  std::vector<geometry::Vec3> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// Errors (kInput, where = name): no triangles, an index without a vertex, a vertex that is not
/// finite or farther than 1e9 m from the origin, more triangles than 2^31.
[[nodiscard]] Status check_mesh(const TriangleMesh& mesh, const std::string& name);

[[nodiscard]] double area_m2(const TriangleMesh& mesh);

/// Points spread evenly over the surfaces, one per spacing_m squared, at most `at_most`;
/// deterministic for each mesh.
[[nodiscard]] std::vector<geometry::Vec3> sample_surface(const TriangleMesh& mesh, double spacing_m,
                                                         std::size_t at_most);

}  // namespace rali::eval
