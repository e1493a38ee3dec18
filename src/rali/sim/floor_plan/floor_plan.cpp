#include "rali/sim/floor_plan/floor_plan.hpp"

namespace rali::sim {

using geometry::Vec3;

namespace {

void add_slab(TriangleMesh& mesh, const SlabPiece& s, double z, double refl) {
  const std::uint32_t a = mesh.add_vertex({s.x0, s.y_low0, z});
  const std::uint32_t b = mesh.add_vertex({s.x1, s.y_low1, z});
  const std::uint32_t c = mesh.add_vertex({s.x1, s.y_high1, z});
  const std::uint32_t d = mesh.add_vertex({s.x0, s.y_high0, z});
  mesh.add_triangle(a, b, c, refl);
  mesh.add_triangle(a, c, d, refl);
}

void add_furniture(TriangleMesh& mesh, const Furniture& f) {
  const Vec3 base(f.at.x(), f.at.y(), f.bottom_m);
  const double height = f.top_m - f.bottom_m;
  if (f.radius_m > 0.0) {
    constexpr int kSides = 20;
    mesh.add_cylinder(base, f.radius_m, height, kSides, f.reflectivity);
  } else {
    mesh.add_box(base, {f.size_m.x(), f.size_m.y(), height}, f.yaw_rad, f.reflectivity);
  }
}

}  // namespace

Result<TriangleMesh> floor_plan_mesh(const FloorPlan& plan) {
  if (plan.areas.empty()) {
    return fail(ErrorCode::kUsage, "floor_plan", "has no free area", "Give at least one.");
  }
  const auto outline = outline_of(plan.areas);
  if (!outline) return tl::make_unexpected(outline.error());
  TriangleMesh mesh;
  for (const WallPiece& wall : outline->walls) {
    mesh.add_quad({wall.a.x(), wall.a.y(), wall.bottom_m},
                  {wall.b.x() - wall.a.x(), wall.b.y() - wall.a.y(), 0.0},
                  {0.0, 0.0, wall.top_m - wall.bottom_m}, wall.reflectivity);
  }
  for (const SlabPiece& slab : outline->slabs) {
    add_slab(mesh, slab, 0.0, plan.floor_reflectivity);
    if (plan.ceiling) add_slab(mesh, slab, slab.height_m, plan.ceiling_reflectivity);
  }
  for (const Furniture& f : plan.furniture) add_furniture(mesh, f);
  return mesh;
}

}  // namespace rali::sim
