#pragma once

#include <array>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/config/field.hpp"
#include "rali/scenario/scene/codecs.hpp"
#include "rali/sim/floor_plan/floor_plan.hpp"

namespace rali::scenario {

/// Largest distance from the origin of anything in a floor plan [m].
inline constexpr double kPlanMax_m = 5000.0;

/// An area of free space: a rectangle from corner to corner, or a polygon whose last corner repeats
/// the first.
struct PlanArea {
  std::array<double, 4> rectangle{};  ///< x0 y0 x1 y1; used if `polygon` is empty
  sim::Polygon polygon;
  double height_m = 0.0;  ///< of the ceiling; 0: that of the plan
  std::string walls;      ///< material; empty: that of the plan
  std::string where;      ///< file:line

  template <class V>
  void visit(V& v) {
    if (polygon.empty()) v("rectangle", rectangle, -kPlanMax_m, kPlanMax_m, "x0, y0, x1, y1");
    v.custom("polygon", ring(polygon), "corners, the last one is the first again");
    v("height_m", height_m, 0.0, 100.0, "of the ceiling, 0 as the whole plan");
    v("walls", walls, "material of its walls");
  }
};

/// A doorway through a wall, or a recess in it: free space with a lower ceiling.
struct PlanOpening {
  std::array<double, 2> at{};  ///< door: centre of the wall; recess: on the face of the wall
  double yaw_deg = 0.0;        ///< direction into the wall
  double width_m = 0.9;
  double depth_m = 0.3;
  double height_m = 2.1;
  std::string walls;
  std::string where;

  template <class V>
  void visit(V& v) {
    v("at", at, -kPlanMax_m, kPlanMax_m, "x, y");
    v("yaw_deg", yaw_deg, -360.0, 360.0, "direction into the wall");
    v("width_m", width_m, 0.05, 100.0, "across yaw_deg");
    v("depth_m", depth_m, 0.02, 100.0, "along yaw_deg");
    v("height_m", height_m, 0.1, 100.0, "of the lintel");
    v("walls", walls, "material of its sides");
  }
};

/// A pillar up to the ceiling: round if it has a radius.
struct PlanPillar {
  std::array<double, 2> at{};
  double radius_m = 0.0;
  std::array<double, 2> size_m{0.4, 0.4};
  double yaw_deg = 0.0;
  std::string material;
  std::string where;

  template <class V>
  void visit(V& v) {
    v("at", at, -kPlanMax_m, kPlanMax_m, "x, y");
    v("radius_m", radius_m, 0.0, 50.0, "of a round pillar, 0 for a square one");
    v("size_m", size_m, 0.02, 100.0, "length and width of a square one");
    v("yaw_deg", yaw_deg, -360.0, 360.0, "turn of a square one");
    v("material", material, "name or reflectivity");
  }
};

/// A box in free space.
struct PlanBox {
  std::array<double, 2> at{};
  std::array<double, 3> size_m{1.0, 1.0, 1.0};
  double bottom_m = 0.0;
  double yaw_deg = 0.0;
  std::string material;
  std::string where;

  template <class V>
  void visit(V& v) {
    v("at", at, -kPlanMax_m, kPlanMax_m, "x, y");
    v("size_m", size_m, 0.01, 500.0, "length, width, height");
    v("bottom_m", bottom_m, 0.0, 100.0, "height of its lower side");
    v("yaw_deg", yaw_deg, -360.0, 360.0, "turn");
    v("material", material, "name or reflectivity");
  }
};

/// A floor plan as written in scene.yaml.
struct PlanSource {
  double height_m = 2.7;
  bool ceiling = true;
  std::string walls = "concrete";
  std::string floor = "screed";
  std::string ceiling_material = "plaster";
  std::map<std::string, double> materials;  ///< added to the built-in ones
  std::vector<PlanArea> areas;
  std::vector<PlanOpening> doors;
  std::vector<PlanOpening> recesses;
  std::vector<PlanPillar> pillars;
  std::vector<PlanBox> furniture;
  int clutter = 0;  ///< number of boxes at random positions off all routes

  template <class V>
  void visit(V& v) {
    v("height_m", height_m, 0.5, 100.0, "of the ceiling");
    v("ceiling", ceiling, "false: open sky");
    v("walls", walls, "material of the walls");
    v("floor", floor, "material of the floor");
    v("ceiling_material", ceiling_material, "material of the ceiling");
    v.custom("materials", reflectivities(materials), "name: reflectivity, 0 to 1");
    v.custom("areas", list_of(areas), "free space");
    v.custom("doors", list_of(doors), "openings in walls");
    v.custom("recesses", list_of(recesses), "niches, closed doors");
    v.custom("pillars", list_of(pillars), "up to the ceiling");
    v.custom("furniture", list_of(furniture), "boxes");
    v("clutter", clutter, 0, 1000, "boxes put at random places off all routes");
  }
};

/// Errors (kUsage) with file and line: a polygon that is open, crosses itself or has too few
/// corners, an unknown material, no area.
[[nodiscard]] Result<sim::FloorPlan> floor_plan_of(const PlanSource& source);

}  // namespace rali::scenario
