#include "rali/sim/fleet/way_planner.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "rali/sim/route.hpp"

namespace rali::sim {

using geometry::Vec3;

namespace {

constexpr double kWide_m = 0.5;     // between middle and wall where there is room
constexpr double kNarrow_m = 0.38;  // the body's corners reach 0.37 m
constexpr double kCell_m = 0.05;    // coarser ones close doors of 0.9 m that lie across their edges
constexpr double kMoved_m = 1.5;    // a goal that is not free, at most
constexpr double kHeight_m = 1.5;   // a goal above the ground, at most
constexpr double kOther_m = 0.5;    // around another vehicle: FleetMotion keeps 0.85 m

NavigationOptions grid_options(double radius_m) {
  NavigationOptions o;
  o.radius_m = radius_m;
  o.cell_m = kCell_m;
  return o;
}

/// The place itself if it is free, else the nearest free one on rings around it.
std::optional<Vec3> free_near(const NavigationGrid& grid, const Vec3& p, double reach_m) {
  constexpr int kDirections = 16;
  const auto on_ground = [&](double x, double y) -> std::optional<Vec3> {
    const std::optional<double> z = grid.ground_at(x, y, p.z());
    if (!z || std::abs(*z - p.z()) > kHeight_m) return std::nullopt;
    const Vec3 place(x, y, *z);
    if (!grid.free_at(place)) return std::nullopt;
    return place;
  };
  if (const std::optional<Vec3> here = on_ground(p.x(), p.y())) return here;
  for (double r = grid.cell_m(); r <= reach_m; r += grid.cell_m()) {
    for (int k = 0; k < kDirections; ++k) {
      const double a = 2.0 * std::numbers::pi * k / kDirections;
      const std::optional<Vec3> place = on_ground(p.x() + r * std::cos(a), p.y() + r * std::sin(a));
      if (place) return place;
    }
  }
  return std::nullopt;
}

Result<std::vector<Vec3>> corners_through(const NavigationGrid& grid, const Vec3& from,
                                          std::span<const Vec3> places, double moved_m) {
  const std::optional<Vec3> start = free_near(grid, from, kMoved_m);
  if (!start) return fail(ErrorCode::kNoAnswer, "from", "no free place near the vehicle");
  constexpr double kNear_m = 0.3;  // as Rover::follow() does
  std::vector<Vec3> way{from};
  Vec3 at = *start;
  for (const Vec3& place : places) {
    const std::optional<Vec3> to = free_near(grid, place, moved_m);
    if (!to) return fail(ErrorCode::kNoAnswer, "to", "no free place near the goal");
    const Result<std::vector<Vec3>> piece = grid.plan(at, *to);
    if (!piece) return tl::make_unexpected(piece.error());
    for (const Vec3& corner : *piece) {
      if (way.size() > 1 || (corner - from).norm() >= kNear_m) way.push_back(corner);
    }
    if (way.size() == 1) way.push_back(*to);
    at = *to;
  }
  return way;
}

/// Adds corners where the ground leaves the straight line between two: a piece may begin on a flat
/// floor and end on a ramp.
std::vector<Vec3> on_the_ground(const NavigationGrid& grid, const std::vector<Vec3>& corners) {
  constexpr double kStep_m = 0.25;
  constexpr double kSame_m = 0.015;  // heights of cells on a slope differ by that
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

/// The largest rounding with which a way of these corners touches nothing; none if all do.
std::optional<double> rounding_for(const Clearance& clearance, const std::vector<Vec3>& corners) {
  constexpr std::array<double, 4> kRoundings{0.8, 0.4, 0.2, 0.05};
  constexpr double kStep_m = 0.1;
  VehicleShape shape;
  shape.radius_m = 0.35;
  double span_m = 0.0;
  for (std::size_t i = 1; i < corners.size(); ++i) span_m += (corners[i] - corners[i - 1]).norm();
  if (span_m < kStep_m) return kRoundings.front();
  for (const double rounding : kRoundings) {
    const Route route(corners, rounding);
    bool free = true;
    // Where the vehicle stands already it does not help to refuse.
    for (double s = 0.5; free && s < route.length_m(); s += kStep_m) {
      free = clearance.free_at(route.point_at(s), shape);
    }
    if (free) return rounding;
  }
  return std::nullopt;
}

Result<PlannedWay> plan_in(const NavigationGrid& grid, const Clearance& clearance, const Vec3& from,
                           std::span<const Vec3> places, double moved_m) {
  const Result<std::vector<Vec3>> corners = corners_through(grid, from, places, moved_m);
  if (!corners) return tl::make_unexpected(corners.error());
  std::vector<Vec3> way = on_the_ground(grid, *corners);
  const std::optional<double> rounding = rounding_for(clearance, way);
  if (!rounding) return fail(ErrorCode::kNoAnswer, "way", "it touches something");
  return PlannedWay{std::move(way), *rounding};
}

TriangleMesh with_vehicles(const TriangleMesh& mesh, std::span<const Vec3> others) {
  TriangleMesh out = mesh;
  for (const Vec3& p : others) out.add_cylinder(p, kOther_m, 0.6, 12, 0.3);
  return out;
}

}  // namespace

WayPlanner::WayPlanner(const TriangleMesh& mesh, NavigationGrid wide, NavigationGrid narrow)
    : mesh_(&mesh), wide_(std::move(wide)), narrow_(std::move(narrow)), clearance_(mesh) {}

Result<WayPlanner> WayPlanner::make(const TriangleMesh& mesh) {
  Result<NavigationGrid> wide = NavigationGrid::build(mesh, grid_options(kWide_m));
  if (!wide) return tl::make_unexpected(wide.error());
  Result<NavigationGrid> narrow = NavigationGrid::build(mesh, grid_options(kNarrow_m));
  if (!narrow) return tl::make_unexpected(narrow.error());
  return WayPlanner(mesh, std::move(*wide), std::move(*narrow));
}

Result<PlannedWay> WayPlanner::plan(const Vec3& from, std::span<const Vec3> places,
                                    std::span<const Vec3> others) const {
  if (others.empty()) {
    // Room to spare must not cost the goal.
    Result<PlannedWay> roomy = plan_in(wide_, clearance_, from, places, 0.1);
    if (roomy) return roomy;
    return plan_in(narrow_, clearance_, from, places, kMoved_m);
  }
  const TriangleMesh crowded = with_vehicles(*mesh_, others);
  const Result<WayPlanner> around = make(crowded);
  if (!around) return tl::make_unexpected(around.error());
  return around->plan(from, places, {});
}

}  // namespace rali::sim
