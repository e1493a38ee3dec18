#pragma once

#include "rali/base/result.hpp"
#include "rali/sim/world.hpp"

namespace rali::sim {

/// Starts and rounds of a fleet along one path.
struct FleetPlan {
  std::vector<VehicleStart> starts;
  std::vector<RoundPlan> rounds;
};

/// How a fleet follows one path.
struct RoundOptions {
  double gap_m = 2.0;   ///< between neighbours in the column, smaller on short paths
  double leg_m = 12.0;  ///< how far the vehicles ahead drive beyond the anchor
};

/// The rounds of the paper along world.route for any number of vehicles, without overtaking. The
/// vehicles form a column, number 0 in front, neighbours on two lanes where the path is wide
/// enough. In each round one vehicle, the anchor, is stationary. Those ahead of it drive up to
/// leg_m on, those behind it close up. The next one ahead then becomes the anchor, after the first
/// the last again. The rounds end when the column is at the end of the path. One vehicle: one round
/// without anchor.
/// Errors (kUsage): no route, or one too short for the column.
[[nodiscard]] Result<FleetPlan> plan_rounds(const World& world, int vehicles,
                                            const RoundOptions& options = {});

/// `points` without those within tolerance_m of the simplified line; first and last are kept
/// (Douglas and Peucker 1973).
[[nodiscard]] std::vector<geometry::Vec3> simplified(const std::vector<geometry::Vec3>& points,
                                                     double tolerance_m);

}  // namespace rali::sim
