#include "rali/scenario/scene/surveyor.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "rali/sim/rounds.hpp"
#include "rali/sim/route.hpp"

namespace rali::scenario {

using geometry::Vec3;

bool is_given(const Vec3& p) { return !std::isnan(p.x()); }

Result<Vec3> Surveyor::on_ground(const Vec3& p, const std::string& name,
                                 const std::string& where) const {
  const std::vector<double> heights = clearance_.surfaces_at(p.x(), p.y());
  if (heights.empty()) {
    return fail(ErrorCode::kUsage, where,
                fmt::format("{} has no ground below it at [{:.2f}, {:.2f}]", name, p.x(), p.y()),
                "Put it inside the free space.");
  }
  std::size_t best = 0;
  for (std::size_t i = 1; i < heights.size() && !std::isnan(p.z()); ++i) {
    if (std::abs(heights[i] - p.z()) < std::abs(heights[best] - p.z())) best = i;
  }
  // From the underside of a floor to its upper side; table tops are higher than that.
  constexpr double kSlab_m = 0.35;
  while (best + 1 < heights.size() && heights[best + 1] - heights[best] < kSlab_m) ++best;
  const Vec3 place(p.x(), p.y(), heights[best]);
  if (!clearance_.free_at(place, shape_)) {
    return fail(ErrorCode::kUsage, where,
                fmt::format("{} stands in a wall or too near to one at [{:.2f}, {:.2f}]: it "
                            "needs {:.2f} m, there are {:.2f} m",
                            name, p.x(), p.y(), shape_.radius_m,
                            clearance_.distance_m(place, shape_, shape_.radius_m)),
                "Move it into free space.");
  }
  return place;
}

Result<Path> Surveyor::along_ground(const Path& path, const Vec3& from, const std::string& name,
                                    const std::string& where) const {
  constexpr double kStep_m = 0.25;
  constexpr double kClimb_m = 0.3;  // largest climb searched above the last point
  constexpr double kDrop_m = 1.0;
  Path corners{from};
  const bool leads_on = (path.front() - from).head<2>().norm() < 0.05;
  corners.insert(corners.end(), path.begin() + (leads_on ? 1 : 0), path.end());
  Path points{from};
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const Vec3 a = corners[i];
    const Vec3 step = corners[i + 1] - a;
    const int n = std::max(1, static_cast<int>(std::ceil(step.head<2>().norm() / kStep_m)));
    for (int k = 1; k <= n; ++k) {
      const double x = a.x() + step.x() * k / n;
      const double y = a.y() + step.y() * k / n;
      const auto z =
          clearance_.ground_below(x, y, points.back().z() + kClimb_m, kClimb_m + kDrop_m);
      if (!z) {
        return fail(ErrorCode::kUsage, where,
                    fmt::format("the path of {} has no ground at [{:.2f}, {:.2f}]", name, x, y),
                    "It leaves the free space there.");
      }
      points.emplace_back(x, y, *z);
    }
  }
  constexpr double kTolerance_m = 0.01;
  return sim::simplified(points, kTolerance_m);
}

Result<Path> Surveyor::planned(const Vec3& from, const Vec3& to, const std::string& where) {
  Error error;
  // First with a larger radius, which leaves room for rounded corners.
  for (const double radius : {0.42, 0.32}) {
    auto grid = grid_of(radius);
    if (!grid) return tl::make_unexpected(grid.error());
    auto path = (*grid)->plan(from, to);
    if (path) return path;
    error = path.error();
  }
  error.where = where;
  return tl::make_unexpected(std::move(error));
}

Result<Path> Surveyor::longest(const Vec3& from, const std::function<bool(const Vec3&)>& inside,
                               const std::string& where) {
  auto grid = grid_of(0.42);
  if (!grid) return tl::make_unexpected(grid.error());
  Vec3 begin = from;
  if (!is_given(from)) {
    const std::vector<Vec3> cells = (*grid)->free_cells();
    const auto cell = std::find_if(cells.begin(), cells.end(), inside);
    if (cell == cells.end()) {
      return fail(ErrorCode::kUsage, where, "no vehicle fits into the free space");
    }
    const auto end = (*grid)->farthest_from(*cell);
    if (!end) return tl::make_unexpected(end.error());
    begin = *end;
  }
  const auto goal = (*grid)->farthest_from(begin);
  if (!goal) return tl::make_unexpected(Error{goal.error().code, goal.error().what, where, ""});
  return (*grid)->plan(begin, *goal);
}

Status Surveyor::check_path(const Path& path, double rounding_m, const std::string& name,
                            const std::string& where) const {
  const sim::Route route(path, rounding_m);
  Path points;
  for (double s = 0.0; s < route.length_m(); s += 0.1) points.push_back(route.point_at(s));
  points.push_back(route.point_at(route.length_m()));
  const auto contact = clearance_.first_contact(points, shape_);
  if (!contact) return {};
  return fail(ErrorCode::kUsage, where,
              fmt::format("the path of {} touches a wall at [{:.2f}, {:.2f}]: a vehicle needs "
                          "{:.2f} m on each side",
                          name, contact->x(), contact->y(), shape_.radius_m),
              "Corners are cut a little; lead the path farther around.");
}

Result<sim::NavigationGrid*> Surveyor::grid_of(double radius_m) {
  if (grid_ && grid_radius_m_ == radius_m) return grid_.get();
  sim::NavigationOptions options;
  options.radius_m = radius_m;
  auto grid = sim::NavigationGrid::build(*mesh_, options);
  if (!grid) return tl::make_unexpected(grid.error());
  grid_ = std::make_unique<sim::NavigationGrid>(std::move(*grid));
  grid_radius_m_ = radius_m;
  return grid_.get();
}

}  // namespace rali::scenario
