#pragma once

#include <vector>

#include "rali/base/result.hpp"
#include "rali/sim/floor_plan/polygon.hpp"

namespace rali::sim {

/// An area of free space. Where areas overlap, the higher ceiling counts.
struct FreeArea {
  Polygon corners;
  double height_m = 2.7;           ///< of the ceiling
  double wall_reflectivity = 0.6;  ///< of the walls around it
};

/// An upright wall along a straight segment. Between free space and none it starts at the ground;
/// between two ceilings it exists only above the lower one.
struct WallPiece {
  geometry::Vec2 a, b;
  double bottom_m = 0.0, top_m = 0.0;
  double reflectivity = 0.6;
};

/// A patch of floor and ceiling: x0 to x1, at each end from y_low to y_high.
struct SlabPiece {
  double x0 = 0.0, x1 = 0.0;
  double y_low0 = 0.0, y_high0 = 0.0, y_low1 = 0.0, y_high1 = 0.0;
  double height_m = 0.0;
};

struct Outline {
  std::vector<WallPiece> walls;  ///< whole straight walls, sorted
  std::vector<SlabPiece> slabs;  ///< without overlap
};

/// Walls and floors of the union of areas without polygon_fault(). All edges are split at their
/// intersections; a segment is a wall where its two sides differ in height.
/// Errors (kUsage): more than 5000 wall segments.
[[nodiscard]] Result<Outline> outline_of(const std::vector<FreeArea>& areas);

/// The area that applies at p: the last of the highest ones; nullptr outside of all.
[[nodiscard]] const FreeArea* area_at(const std::vector<FreeArea>& areas, const geometry::Vec2& p);

}  // namespace rali::sim
