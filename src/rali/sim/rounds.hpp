#pragma once

#include "rali/base/result.hpp"
#include "rali/sim/world.hpp"

namespace rali::sim {

/// Starts and rounds of a fleet along one way.
struct FleetPlan {
  std::vector<VehicleStart> starts;
  std::vector<RoundPlan> rounds;
};

/// How a fleet follows one way.
struct RoundOptions {
  double gap_m = 2.0;   ///< between neighbours in the column, smaller on short ways
  double leg_m = 12.0;  ///< how far the ones ahead go beyond the anchor
};

/// The rounds of the paper along world.route for any number of vehicles, nobody overtaking: the
/// vehicles stand in a column, number 0 in front, neighbours on two lanes where the way is wide
/// enough. In each round one stands; those ahead of it drive up to leg_m on, those behind it close
/// up; then the next one ahead is the anchor, after the first the last again. It ends when the
/// column stands at the end of the way. One vehicle: one round without anchor along the route.
/// Errors (kUsage): no route, or one too short for the column.
[[nodiscard]] Result<FleetPlan> plan_rounds(const World& world, int vehicles,
                                            const RoundOptions& options = {});

/// Corners of `points` that a line through their neighbours misses by more than tolerance_m, first
/// and last (Douglas and Peucker 1973).
[[nodiscard]] std::vector<geometry::Vec3> simplified(const std::vector<geometry::Vec3>& points,
                                                     double tolerance_m);

}  // namespace rali::sim
