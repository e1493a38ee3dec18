#include "rali/sim/fleet/path_planner.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "rali/sim/route.hpp"

namespace rali::sim {

using geometry::Vec3;

namespace {

constexpr double kWide_m = 0.5;     // vehicle centre to wall where space allows
constexpr double kNarrow_m = 0.38;  // the body's corners reach 0.37 m
constexpr double kCell_m = 0.05;    // coarser cells close doors of 0.9 m that lie across cell edges
constexpr double kMoved_m = 1.5;    // largest shift of a goal that is not free
constexpr double kHeight_m = 1.5;   // largest height of a goal above the ground
constexpr double kOther_m = 0.5;    // around another vehicle: FleetMotion keeps 0.85 m
constexpr double kBody_m = 0.35;    // smallest distance of obstacles from a path, ...
constexpr double kBegun_m = 0.5;    // ... except on this first part if it starts too close to one
constexpr double kCheck_m = 0.1;    // between checked positions of a path

NavigationOptions grid_options(double radius_m) {
  NavigationOptions o;
  o.radius_m = radius_m;
  o.cell_m = kCell_m;
  return o;
}

/// A position that a vehicle can occupy, and its connected component of the grid.
struct FreePlace {
  Vec3 p;
  std::int32_t part = 0;
};

/// The position itself if it is free. Otherwise the nearest free position of each component of the
/// grid, searched on rings around it, nearest first.
std::vector<FreePlace> free_near(const NavigationGrid& grid, const Vec3& p, double reach_m) {
  constexpr int kDirections = 16;
  std::vector<FreePlace> out;
  const auto look = [&](double x, double y) {
    const std::optional<double> z = grid.ground_at(x, y, p.z());
    if (!z || std::abs(*z - p.z()) > kHeight_m) return;
    const Vec3 place(x, y, *z);
    const std::int32_t part = grid.part_at(place);
    const auto has = [part](const FreePlace& f) { return f.part == part; };
    if (part >= 0 && std::none_of(out.begin(), out.end(), has)) out.push_back({place, part});
  };
  look(p.x(), p.y());
  if (!out.empty()) return out;
  for (double r = grid.cell_m(); r <= reach_m; r += grid.cell_m()) {
    for (int k = 0; k < kDirections; ++k) {
      const double a = 2.0 * std::numbers::pi * k / kDirections;
      look(p.x() + r * std::cos(a), p.y() + r * std::sin(a));
    }
  }
  return out;
}

/// Free positions near all of `places` in the same component of the grid; empty if there are none.
std::vector<Vec3> free_in_part(const NavigationGrid& grid, std::span<const Vec3> places,
                               double moved_m, std::int32_t part) {
  std::vector<Vec3> out;
  for (const Vec3& place : places) {
    const std::vector<FreePlace> near = free_near(grid, place, moved_m);
    const auto at = std::find_if(near.begin(), near.end(),
                                 [part](const FreePlace& f) { return f.part == part; });
    if (at == near.end()) return {};
    out.push_back(at->p);
  }
  return out;
}

Result<std::vector<Vec3>> corners_through(const NavigationGrid& grid, const Vec3& from,
                                          std::span<const Vec3> places, double moved_m) {
  const std::vector<FreePlace> starts = free_near(grid, from, kMoved_m);
  if (starts.empty()) return fail(ErrorCode::kNoAnswer, "from", "no free place near the vehicle");
  for (const FreePlace& start : starts) {
    const std::vector<Vec3> ends = free_in_part(grid, places, moved_m, start.part);
    if (ends.empty()) continue;
    std::vector<Vec3> path{from};
    Vec3 at = start.p;
    for (const Vec3& to : ends) {
      const Result<std::vector<Vec3>> piece = grid.plan(at, to);
      if (!piece) return tl::make_unexpected(piece.error());
      path.insert(path.end(), piece->begin(), piece->end());
      at = to;
    }
    return path;
  }
  return fail(ErrorCode::kNoAnswer, "to", "no way leads to a free place near the goal");
}

/// True if a vehicle on a path touches nothing. A path may start too close to an obstacle, where
/// the vehicle already is; once it is free it must stay free.
template <class PointAt>
bool is_free(const Clearance& clearance, double length_m, const PointAt& point_at) {
  VehicleShape shape;
  shape.radius_m = kBody_m;
  bool begun = false;
  for (double s = 0.0; s < length_m; s += kCheck_m) {
    const bool free = clearance.free_at(point_at(s), shape);
    if (!free && (begun || s >= kBegun_m)) return false;
    begun = begun || free;
  }
  return true;
}

bool line_is_free(const Clearance& clearance, const Vec3& from, const Vec3& to) {
  const double length_m = (to - from).norm();
  return is_free(clearance, length_m,
                 [&](double s) -> Vec3 { return from + s / length_m * (to - from); });
}

/// Removes first corners so close that they only make the vehicle turn to and fro, if the straight
/// line to the next one is free.
std::vector<Vec3> without_near_corners(const Clearance& clearance, std::vector<Vec3> path) {
  constexpr double kNear_m = 0.3;
  std::size_t next = 1;
  while (next + 1 < path.size() && (path[next] - path.front()).norm() < kNear_m) ++next;
  while (next > 1 && !line_is_free(clearance, path.front(), path[next])) --next;
  path.erase(path.begin() + 1, path.begin() + static_cast<std::ptrdiff_t>(next));
  return path;
}

/// Adds corners where the ground leaves the straight line between two: a segment may begin on a
/// flat floor and end on a ramp.
std::vector<Vec3> on_the_ground(const NavigationGrid& grid, const std::vector<Vec3>& corners) {
  constexpr double kStep_m = 0.25;
  constexpr double kSame_m = 0.015;  // cell heights on a slope differ by that
  std::vector<Vec3> out{corners.front()};
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const Vec3 piece = corners[i] - corners[i - 1];
    const int n = std::max(1, static_cast<int>(piece.norm() / kStep_m));
    for (int k = 1; k < n; ++k) {
      Vec3 p = corners[i - 1] + piece * (static_cast<double>(k) / n);
      const std::optional<double> z = grid.ground_at(p.x(), p.y(), p.z());
      if (!z || std::abs(*z - p.z()) < kSame_m) continue;
      p.z() = *z;
      out.push_back(p);
    }
    out.push_back(corners[i]);
  }
  return out;
}

/// The largest rounding with which the path touches nothing; none if it touches with every
/// rounding.
std::optional<double> rounding_for(const Clearance& clearance, const std::vector<Vec3>& corners) {
  constexpr std::array<double, 4> kRoundings{0.8, 0.4, 0.2, 0.05};
  double span_m = 0.0;
  for (std::size_t i = 1; i < corners.size(); ++i) span_m += (corners[i] - corners[i - 1]).norm();
  if (span_m < kCheck_m) return kRoundings.front();
  for (const double rounding : kRoundings) {
    const Route route(corners, rounding);
    const auto point_at = [&route](double s) { return route.point_at(s); };
    if (is_free(clearance, route.length_m(), point_at)) return rounding;
  }
  return std::nullopt;
}

Result<PlannedPath> plan_in(const NavigationGrid& grid, const Clearance& clearance,
                            const Vec3& from, std::span<const Vec3> places, double moved_m) {
  const Result<std::vector<Vec3>> corners = corners_through(grid, from, places, moved_m);
  if (!corners) return tl::make_unexpected(corners.error());
  const std::vector<Vec3> path = on_the_ground(grid, without_near_corners(clearance, *corners));
  const std::optional<double> rounding = rounding_for(clearance, path);
  if (!rounding) return fail(ErrorCode::kNoAnswer, "way", "it touches something");
  return PlannedPath{path, *rounding};
}

TriangleMesh with_vehicles(const TriangleMesh& mesh, std::span<const Vec3> others) {
  TriangleMesh out = mesh;
  for (const Vec3& p : others) out.add_cylinder(p, kOther_m, 0.6, 12, 0.3);
  return out;
}

}  // namespace

PathPlanner::PathPlanner(const TriangleMesh& mesh, NavigationGrid wide, NavigationGrid narrow)
    : mesh_(&mesh), wide_(std::move(wide)), narrow_(std::move(narrow)), clearance_(mesh) {}

Result<PathPlanner> PathPlanner::make(const TriangleMesh& mesh) {
  Result<NavigationGrid> wide = NavigationGrid::build(mesh, grid_options(kWide_m));
  if (!wide) return tl::make_unexpected(wide.error());
  Result<NavigationGrid> narrow = NavigationGrid::build(mesh, grid_options(kNarrow_m));
  if (!narrow) return tl::make_unexpected(narrow.error());
  return PathPlanner(mesh, std::move(*wide), std::move(*narrow));
}

Result<PlannedPath> PathPlanner::plan(const Vec3& from, std::span<const Vec3> places,
                                      std::span<const Vec3> others) const {
  if (others.empty()) {
    // Fall back to narrow passages: extra clearance must not make the goal unreachable.
    Result<PlannedPath> roomy = plan_in(wide_, clearance_, from, places, 0.1);
    if (roomy) return roomy;
    return plan_in(narrow_, clearance_, from, places, kMoved_m);
  }
  const TriangleMesh crowded = with_vehicles(*mesh_, others);
  const Result<PathPlanner> around = make(crowded);
  if (!around) return tl::make_unexpected(around.error());
  return around->plan(from, places, {});
}

}  // namespace rali::sim
