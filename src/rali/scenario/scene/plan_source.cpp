#include "rali/scenario/scene/plan_source.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "rali/config/suggest.hpp"

namespace rali::scenario {

using geometry::Vec2;

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

/// Approximate fraction of 905 nm light that is reflected.
constexpr std::array<std::pair<std::string_view, double>, 11> kMaterials = {{
    {"concrete", 0.6},
    {"plaster", 0.7},
    {"screed", 0.4},
    {"brick", 0.45},
    {"rock", 0.25},
    {"asphalt", 0.15},
    {"wood", 0.5},
    {"steel", 0.55},
    {"glass", 0.08},
    {"white", 0.9},
    {"black", 0.05},
}};

/// Looks up materials; keeps the first error.
class Materials {
 public:
  explicit Materials(const PlanSource& source) : own_(source.materials) {}

  double of(const std::string& name, const std::string& fallback, const std::string& where) {
    const std::string& word = name.empty() ? fallback : name;
    if (const auto own = own_.find(word); own != own_.end()) return own->second;
    for (const auto& [known, value] : kMaterials) {
      if (known == word) return value;
    }
    double number = 0.0;
    if (config::parse_double(word, number) && number >= 0.0 && number <= 1.0) return number;
    if (status_) {
      std::vector<std::string> names;
      for (const auto& material : kMaterials) names.emplace_back(material.first);
      for (const auto& material : own_) names.push_back(material.first);
      const std::string near = config::nearest_name(word, names);
      status_ =
          fail(ErrorCode::kUsage, where,
               fmt::format("there is no material {}", config::yaml_quoted(word.substr(0, 60))),
               near.empty() ? "Name it under floor_plan.materials, or give a number of 0 to 1."
                            : fmt::format("Did you mean '{}'?", near));
    }
    return 0.5;
  }

  [[nodiscard]] const Status& status() const { return status_; }

 private:
  const std::map<std::string, double>& own_;
  Status status_;
};

Result<sim::Polygon> corners_of(const PlanArea& area) {
  if (!area.polygon.empty()) return area.polygon;
  const std::array<double, 4>& r = area.rectangle;
  if (!(r[0] < r[2] && r[1] < r[3])) {
    return fail(
        ErrorCode::kUsage, area.where,
        fmt::format("the area [{:.6g}, {:.6g}, {:.6g}, {:.6g}] is empty", r[0], r[1], r[2], r[3]),
        "Give `rectangle: [x0, y0, x1, y1]` with x0 < x1 and y0 < y1, or a polygon.");
  }
  return sim::rectangle(r[0], r[1], r[2], r[3]);
}

sim::Polygon opening(const PlanOpening& o, bool door) {
  const double yaw = o.yaw_deg * kDegree;
  const Vec2 at(o.at[0], o.at[1]);
  const Vec2 into(std::cos(yaw), std::sin(yaw));
  return sim::rectangle(door ? at : Vec2(at + 0.5 * o.depth_m * into), {o.depth_m, o.width_m}, yaw);
}

void add_things(const PlanSource& source, Materials& materials, sim::FloorPlan& plan) {
  for (const PlanPillar& p : source.pillars) {
    const Vec2 at(p.at[0], p.at[1]);
    const sim::FreeArea* area = sim::area_at(plan.areas, at);
    plan.furniture.push_back({at,
                              {p.size_m[0], p.size_m[1]},
                              p.radius_m,
                              0.0,
                              area != nullptr ? area->height_m : source.height_m,
                              p.yaw_deg * kDegree,
                              materials.of(p.material, source.walls, p.where)});
  }
  for (const PlanBox& b : source.furniture) {
    plan.furniture.push_back({{b.at[0], b.at[1]},
                              {b.size_m[0], b.size_m[1]},
                              0.0,
                              b.bottom_m,
                              b.bottom_m + b.size_m[2],
                              b.yaw_deg * kDegree,
                              materials.of(b.material, "wood", b.where)});
  }
}

}  // namespace

Result<sim::FloorPlan> floor_plan_of(const PlanSource& source) {
  sim::FloorPlan plan;
  Materials materials(source);
  plan.ceiling = source.ceiling;
  plan.floor_reflectivity = materials.of(source.floor, "screed", "floor_plan.floor");
  plan.ceiling_reflectivity =
      materials.of(source.ceiling_material, "plaster", "floor_plan.ceiling_material");
  (void)materials.of(source.walls, "concrete", "floor_plan.walls");
  for (const PlanArea& area : source.areas) {
    auto corners = corners_of(area);
    if (!corners) return tl::make_unexpected(corners.error());
    plan.areas.push_back({std::move(*corners),
                          area.height_m > 0.0 ? area.height_m : source.height_m,
                          materials.of(area.walls, source.walls, area.where)});
  }
  for (const bool door : {true, false}) {
    for (const PlanOpening& o : door ? source.doors : source.recesses) {
      plan.areas.push_back(
          {opening(o, door), o.height_m, materials.of(o.walls, source.walls, o.where)});
    }
  }
  add_things(source, materials, plan);
  if (!materials.status()) return tl::make_unexpected(materials.status().error());
  if (source.areas.empty()) {
    return fail(ErrorCode::kUsage, "floor_plan", "has no areas, so there is no free space",
                "Give at least `areas: [{rectangle: [0, 0, 10, 5]}]`.");
  }
  return plan;
}

}  // namespace rali::scenario
