#pragma once

#include <string>
#include <vector>

#include "rali/geometry/types.hpp"

namespace rali::sim {

/// Corners of a polygon without the repeated first one; clockwise or counter-clockwise.
using Polygon = std::vector<geometry::Vec2>;

/// The fault of a polygon as the end of a sentence ("crosses itself near [1, 2]"); empty if there
/// is none: three corners or more, all finite and within 100 km, no two the same, an area, no edge
/// crossing another.
[[nodiscard]] std::string polygon_fault(const Polygon& polygon);

/// Even-odd rule; points on the edge may count as inside or outside.
[[nodiscard]] bool is_inside(const Polygon& polygon, const geometry::Vec2& p);

/// Rectangle about its centre, rotated by yaw.
[[nodiscard]] Polygon rectangle(const geometry::Vec2& middle, const geometry::Vec2& size_m,
                                double yaw_rad);

/// Axis-aligned rectangle between two opposite corners.
[[nodiscard]] Polygon rectangle(double x0, double y0, double x1, double y1);

}  // namespace rali::sim
