#pragma once

#include <cstdint>
#include <vector>

#include "rali/sim/mesh.hpp"

namespace rali::sim::internal {

/// Height interval that the surfaces of a mesh occupy in one cell of the plan view.
struct Span {
  std::int32_t x = 0, y = 0;
  float low_m = 0.0F, high_m = 0.0F;
};

[[nodiscard]] inline bool same_cell(const Span& a, const Span& b) {
  return a.x == b.x && a.y == b.y;
}

/// Upper bound of the number of cells covered by the triangles, each triangle counted separately.
[[nodiscard]] double cells_touched(const TriangleMesh& mesh, double cell_m);

/// The spans of all cells, sorted by y, x, height; overlapping spans are merged.
[[nodiscard]] std::vector<Span> rasterised(const TriangleMesh& mesh, const geometry::Vec2& low,
                                           double cell_m);

}  // namespace rali::sim::internal
