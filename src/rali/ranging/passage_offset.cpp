#include "rali/ranging/passage_offset.hpp"

#include <algorithm>
#include <cmath>

namespace rali::ranging {

namespace {

/// Offset to the left of the passage's middle.
double offset_m(const PassageWalls& walls) { return 0.5 * (walls.right_m - walls.left_m); }

double width_m(const PassageWalls& walls) { return walls.left_m + walls.right_m; }

}  // namespace

LateralOffset lateral_offset_in_passage(const FinderSettings& settings,
                                        const std::optional<LateralOffset>& by_walls,
                                        double range_m) {
  LateralOffset out = by_walls.value_or(LateralOffset{0.0, settings.passage_m});
  const double bend_m = 0.5 * range_m * range_m / settings.bend_radius_m;
  out.sigma_m += std::min(settings.passage_per_m * range_m, bend_m);
  return out;
}

LateralOffset lateral_offset_between_walls(const FinderSettings& settings,
                                           const PassageWalls& own) {
  const double room_m = std::max(0.0, width_m(own) - 2.0 * settings.wall_m);
  // Uniform distribution: its sigma is its width by the root of twelve.
  return {-offset_m(own), std::max(settings.wall_m, room_m) / std::sqrt(12.0)};
}

std::optional<LateralOffset> lateral_offset_by_walls(const FinderSettings& settings,
                                                     const PassageWalls& own,
                                                     const PassageWalls& other) {
  const double turned = own.axis.dot(other.axis);
  if (std::abs(turned) < std::cos(settings.walls_turn_rad)) return std::nullopt;
  const double other_m = turned < 0.0 ? -offset_m(other) : offset_m(other);
  const double box_m = 0.5 * std::abs(width_m(own) - width_m(other));
  return LateralOffset{other_m - offset_m(own), std::hypot(settings.walls_sigma_m, box_m)};
}

}  // namespace rali::ranging
