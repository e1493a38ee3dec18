#pragma once

#include "rali/sim/floor_plan/outline.hpp"
#include "rali/sim/mesh.hpp"

namespace rali::sim {

/// An object in free space: a box, or a cylinder if it has a radius.
struct Furniture {
  geometry::Vec2 at = geometry::Vec2::Zero();      ///< its centre
  geometry::Vec2 size_m = geometry::Vec2::Ones();  ///< length and width of a box
  double radius_m = 0.0;                           ///< > 0: a cylinder
  double bottom_m = 0.0, top_m = 1.0;
  double yaw_rad = 0.0;
  double reflectivity = 0.5;
};

/// One level storey. Doors and recesses are free areas with a lower ceiling.
struct FloorPlan {
  std::vector<FreeArea> areas;
  std::vector<Furniture> furniture;  ///< pillars too
  bool ceiling = true;               ///< false: open sky
  double floor_reflectivity = 0.4;
  double ceiling_reflectivity = 0.7;
};

/// Floor at z = 0, ceilings, walls where free space ends, furniture.
/// Errors (kUsage): no area; too many walls.
[[nodiscard]] Result<TriangleMesh> floor_plan_mesh(const FloorPlan& plan);

}  // namespace rali::sim
