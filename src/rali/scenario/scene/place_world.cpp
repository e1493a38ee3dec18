#include "rali/scenario/scene/place_world.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "rali/base/rng.hpp"
#include "rali/io/files/mesh_file.hpp"

namespace rali::scenario {

using geometry::Vec2;
using geometry::Vec3;

namespace {

constexpr double kExtentMax_m = 20'000.0;
constexpr std::size_t kTrianglesMax = 20'000'000;
constexpr std::array<double, kUnitNames.size()> kUnit_m{1.0, 0.01, 0.001, 0.0254, 0.3048};

/// Rotates the file's axes to z up, keeping handedness.
geometry::Vec3f upright(const geometry::Vec3f& p, UpAxis up) {
  if (up == UpAxis::kY) return {p.x(), -p.z(), p.y()};
  if (up == UpAxis::kX) return {-p.z(), p.y(), p.x()};
  return p;
}

Result<sim::World> mesh_world(const SceneSetup& setup) {
  auto file = io::read_mesh_file(setup.mesh.file);
  if (!file) return tl::make_unexpected(file.error());
  const double scale = setup.mesh.scale * kUnit_m[static_cast<std::size_t>(setup.mesh.units)];
  sim::World world;
  world.mesh.vertices = std::move(file->vertices);
  for (geometry::Vec3f& v : world.mesh.vertices) {
    v = static_cast<float>(scale) * upright(v, setup.mesh.up);
  }
  world.mesh.triangles = std::move(file->triangles);
  world.mesh.reflectivity = std::move(file->reflectivity);
  world.mesh.reflectivity.resize(world.mesh.triangles.size(),
                                 static_cast<float>(setup.mesh.reflectivity));
  return world;
}

Result<sim::World> plan_world(const SceneSetup& setup) {
  const auto plan = floor_plan_of(setup.floor_plan);
  if (!plan) return tl::make_unexpected(plan.error());
  auto mesh = sim::floor_plan_mesh(*plan);
  if (!mesh) return tl::make_unexpected(mesh.error());
  sim::World world;
  world.mesh = std::move(*mesh);
  return world;
}

Result<sim::World> any_world(const SceneSetup& setup) {
  const Rng rng(setup.fleet.vehicle.seed, kPlaceNames[static_cast<std::size_t>(setup.place)]);
  switch (setup.place) {
    case PlaceKind::kScene:
      return sim::make_world(setup.scene, setup.fleet.vehicle.seed);
    case PlaceKind::kFloorPlan:
      return plan_world(setup);
    case PlaceKind::kTunnel:
      return sim::tunnel_world(setup.tunnel, rng);
    case PlaceKind::kMine:
      return sim::mine_world(setup.mine, rng);
    case PlaceKind::kRamp:
      return sim::ramp_world(setup.ramp, rng);
    case PlaceKind::kMesh:
      return mesh_world(setup);
  }
  return fail(ErrorCode::kUsage, setup.name, "does not say what the place is");
}

Status check_size(const sim::World& world, const SceneSetup& setup) {
  if (world.mesh.triangles.size() > kTrianglesMax) {
    return fail(ErrorCode::kUsage, setup.name,
                fmt::format("the world has {} triangles; at most {} are possible",
                            world.mesh.triangles.size(), kTrianglesMax),
                "Cut the mesh to the part that is driven, or thin it out.");
  }
  const Vec3 low = world.mesh.lower_corner();
  const Vec3 high = world.mesh.upper_corner();
  const double maximum = std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff());
  if (maximum <= kExtentMax_m) return {};
  return fail(ErrorCode::kUsage, setup.name,
              fmt::format("the world reaches {:.6g} m from the origin; at most {} m are possible",
                          maximum, kExtentMax_m),
              setup.place == PlaceKind::kMesh ? "Check mesh.units and mesh.scale." : "");
}

bool off_paths(const Vec2& at, double away_m, const std::vector<std::vector<Vec3>>& paths) {
  for (const auto& path : paths) {
    for (std::size_t i = 0; i + 1 < path.size(); ++i) {
      const Vec2 a = path[i].head<2>();
      const Vec2 ab = path[i + 1].head<2>() - a;
      const double squared = ab.squaredNorm();
      const double u = squared > 0.0 ? std::clamp((at - a).dot(ab) / squared, 0.0, 1.0) : 0.0;
      if ((at - a - u * ab).norm() < away_m) return false;
    }
  }
  return true;
}

}  // namespace

Result<sim::World> place_world(const SceneSetup& setup) {
  auto world = any_world(setup);
  if (!world) {
    Error error = world.error();
    // Errors of the world's own kind contain only its name, so the file is added.
    if (error.code == ErrorCode::kUsage && error.where.find(':') == std::string::npos) {
      error.where = setup.name + ": " + error.where;
    }
    return tl::make_unexpected(std::move(error));
  }
  if (auto status = check_size(*world, setup); !status) return tl::make_unexpected(status.error());
  return world;
}

void add_clutter(const PlanSource& source, const std::vector<std::vector<Vec3>>& paths,
                 std::uint64_t seed, sim::TriangleMesh& mesh) {
  const auto plan = floor_plan_of(source);
  if (!plan || source.clutter == 0) return;
  Rng rng(seed, "clutter");
  const Vec3 low = mesh.lower_corner();
  const Vec3 high = mesh.upper_corner();
  int placed = 0;
  for (int tries = 0; placed < source.clutter && tries < 50 * source.clutter; ++tries) {
    const Vec2 at(rng.uniform(low.x(), high.x()), rng.uniform(low.y(), high.y()));
    const Vec3 size(rng.uniform(0.3, 1.2), rng.uniform(0.3, 0.7), rng.uniform(0.4, 1.9));
    const double yaw = rng.uniform(0.0, 6.28);
    const double refl = rng.uniform(0.2, 0.8);
    const double half = 0.5 * size.head<2>().norm();
    constexpr double kPassage_m = 0.9;
    const auto near_door = [&](const PlanOpening& o) {
      return (Vec2(o.at[0], o.at[1]) - at).norm() < half + kPassage_m + 0.5 * o.width_m;
    };
    if (sim::area_at(plan->areas, at) == nullptr) continue;
    if (std::any_of(source.doors.begin(), source.doors.end(), near_door)) continue;
    if (!off_paths(at, half + kPassage_m, paths)) continue;
    mesh.add_box({at.x(), at.y(), 0.0}, size, yaw, refl);
    ++placed;
  }
}

}  // namespace rali::scenario
