#include "rali/ranging/seen_space.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace rali::ranging {

using geometry::Vec3;

namespace {

constexpr double kNear_m = 12.0;   ///< of places from which a point can be seen
constexpr std::size_t kViews = 4;  ///< of the nearest of them: one may look past a pillar
constexpr double kStep_m = 1.0;    ///< of points on the line
constexpr int kInARow = 3;         ///< points outside: a pillar hides one or two
constexpr double kWall_m = 0.3;    ///< a point is on a surface that is nearer

}  // namespace

bool is_outside(const Vec3& p_m, std::span<const Vec3> places_m, const SurfacesBetween& surfaces) {
  std::vector<std::pair<double, std::size_t>> near;
  for (std::size_t i = 0; i < places_m.size(); ++i) {
    const double distance_m = (places_m[i] - p_m).norm();
    if (distance_m < kNear_m) near.emplace_back(distance_m, i);
  }
  if (near.empty()) return false;
  const auto views = near.begin() + static_cast<std::ptrdiff_t>(std::min(near.size(), kViews));
  std::partial_sort(near.begin(), views, near.end());
  return std::all_of(near.begin(), views, [&](const std::pair<double, std::size_t>& view) {
    const auto& [distance_m, i] = view;
    if (distance_m < 2.0 * kWall_m) return false;
    const Vec3 sight_m = (1.0 - kWall_m / distance_m) * (p_m - places_m[i]);
    return surfaces(places_m[i], places_m[i] + sight_m) > 0;
  });
}

bool leaves_seen_space(const Vec3& p_m, const Vec3& q_m,
                       const std::function<bool(const Vec3&)>& outside) {
  const auto steps = static_cast<int>((q_m - p_m).norm() / kStep_m);
  int in_a_row = 0;
  for (int k = 1; k < steps; ++k) {
    const Vec3 x_m = p_m + (static_cast<double>(k) / steps) * (q_m - p_m);
    in_a_row = outside(x_m) ? in_a_row + 1 : 0;
    if (in_a_row >= kInARow) return true;
  }
  return false;
}

}  // namespace rali::ranging
