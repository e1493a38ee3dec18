#include "rali/sim/internal/spans.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "rali/sim/internal/clip.hpp"

namespace rali::sim::internal {

using geometry::Vec3;

namespace {

ClipPolygon polygon_of(const TriangleMesh& mesh, std::size_t triangle) {
  ClipPolygon polygon;
  for (const std::uint32_t v : mesh.triangles[triangle]) {
    polygon.add(mesh.vertices[v].cast<double>());
  }
  return polygon;
}

struct Extent {
  double low = 0.0, high = 0.0;
};

Extent extent(const ClipPolygon& polygon, int axis) {
  Extent e{polygon.at(0)[axis], polygon.at(0)[axis]};
  for (int i = 1; i < polygon.size; ++i) {
    e.low = std::min(e.low, polygon.at(i)[axis]);
    e.high = std::max(e.high, polygon.at(i)[axis]);
  }
  return e;
}

std::int32_t cell_of(double value, double low, double cell_m) {
  return static_cast<std::int32_t>(std::floor((value - low) / cell_m));
}

/// Cuts a triangle into rows, the rows into cells.
void rasterise(const ClipPolygon& triangle, const geometry::Vec2& low, double cell_m,
               std::vector<Span>& spans) {
  const Extent y = extent(triangle, 1);
  for (std::int32_t j = cell_of(y.low, low.y(), cell_m); j <= cell_of(y.high, low.y(), cell_m);
       ++j) {
    const double y0 = low.y() + j * cell_m;
    const ClipPolygon row = clipped_between(triangle, 1, y0, y0 + cell_m);
    if (row.size == 0) continue;
    const Extent x = extent(row, 0);
    for (std::int32_t i = cell_of(x.low, low.x(), cell_m); i <= cell_of(x.high, low.x(), cell_m);
         ++i) {
      const double x0 = low.x() + i * cell_m;
      const ClipPolygon cell = clipped_between(row, 0, x0, x0 + cell_m);
      if (cell.size == 0) continue;
      const Extent z = extent(cell, 2);
      spans.push_back({i, j, static_cast<float>(z.low), static_cast<float>(z.high)});
    }
  }
}

}  // namespace

double cells_touched(const TriangleMesh& mesh, double cell_m) {
  double cells = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const ClipPolygon triangle = polygon_of(mesh, t);
    const Extent x = extent(triangle, 0);
    const Extent y = extent(triangle, 1);
    cells += (std::floor((x.high - x.low) / cell_m) + 2.0) *
             (std::floor((y.high - y.low) / cell_m) + 2.0);
  }
  return cells;
}

std::vector<Span> rasterised(const TriangleMesh& mesh, const geometry::Vec2& low, double cell_m) {
  std::vector<Span> spans;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    rasterise(polygon_of(mesh, t), low, cell_m, spans);
  }
  std::sort(spans.begin(), spans.end(), [](const Span& a, const Span& b) {
    return std::tie(a.y, a.x, a.low_m, a.high_m) < std::tie(b.y, b.x, b.low_m, b.high_m);
  });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < spans.size(); ++i) {
    if (kept > 0 && same_cell(spans[kept - 1], spans[i]) &&
        spans[i].low_m <= spans[kept - 1].high_m) {
      spans[kept - 1].high_m = std::max(spans[kept - 1].high_m, spans[i].high_m);
    } else {
      spans[kept++] = spans[i];
    }
  }
  spans.resize(kept);
  return spans;
}

}  // namespace rali::sim::internal
