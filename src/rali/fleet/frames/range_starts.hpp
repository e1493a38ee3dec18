#pragma once

#include <optional>
#include <vector>

#include "rali/fleet/frames/frame_problem.hpp"

namespace rali::fleet {

/// A range in the plane: antennas in their own frames, height difference removed.
struct PlanarRange {
  geometry::Vec2 x_m, y_m;
  double range_m = 0.0, sigma_m = 0.1;
};

/// Least squares for t from r^2 - |z|^2 = 2 z.t + |t|^2, z = R(yaw) x - y, with singular directions
/// truncated (algorithms_fleet 7.4, step 1).
struct LinearStart {
  geometry::Vec2 t_m = geometry::Vec2::Zero();
  double square_m2 = 0.0;  ///< |t|^2, solved as an independent unknown
  geometry::Vec2 mean_m = geometry::Vec2::Zero();
  geometry::Vec2 along = geometry::Vec2::UnitX();  ///< principal line of the z
};

[[nodiscard]] LinearStart linear_start(const std::vector<PlanarRange>& ranges, double yaw_rad);

/// Initial translations at this yaw: the linear one, its mirror image across the principal line of
/// the z, and the two points on both sides of that line at the mean distance.
[[nodiscard]] std::vector<geometry::Vec2> planar_starts(const std::vector<PlanarRange>& ranges,
                                                        double yaw_rad);

/// A solution of the search.
struct PlanarSolution {
  double yaw_rad = 0.0;
  geometry::Vec2 t_m = geometry::Vec2::Zero();
  double chi2 = 0.0;
};

/// All minima of sum huber((|R(yaw) x + t - y| + b - r)/sigma) + (b/bias_sigma)^2, cheapest first:
/// damped Gauss-Newton from each start, merged. Odometry errors are not modelled, so the caller
/// refines the result. If `yaw_fixed`, yaw is 0: ranges to a vehicle at standstill do not determine
/// it.
[[nodiscard]] std::vector<PlanarSolution> search_plane(const std::vector<PlanarRange>& ranges,
                                                       bool yaw_fixed,
                                                       const InitSettings& settings);

}  // namespace rali::fleet
