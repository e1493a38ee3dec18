#pragma once

#include <map>
#include <vector>

#include "slam_placing.hpp"

namespace rali::ranges_bench {

/// Statistics of the range innovations before the graph uses the ranges.
struct Innovations {
  std::size_t count = 0, beyond = 0;  ///< beyond: NIS above 10.83, 0.1 % if consistent
  double sum_m = 0.0, square_m2 = 0.0, nis = 0.0;
};

struct SlamEstimate {
  eval::PoseList poses;
  std::map<int, geometry::Vec3> beacons_m;  ///< in odom
  std::map<int, double> biases_m;
  Innovations innovations;  ///< of the window only
  double cost = 0.0;
  int iterations = 0;
};

/// All poses and ranges at once in a graph::PoseGraph, nothing marginalised. Beacons start at
/// `placed` with a prior of 1 km. Ranges are attached to their poses.
[[nodiscard]] SlamEstimate solve_batch(const SlamProblem& problem, const eval::PoseList& initial,
                                       const std::map<int, geometry::Vec3>& placed);

/// solve_batch() from the initial beacon positions. A single beacon that was not certain is also
/// started in eight directions around its first range. With known points, several initial poses of
/// the frame are tried (place_frame). The result is the solution with the lowest cost.
[[nodiscard]] SlamEstimate solve_batch_from(const SlamProblem& problem,
                                            const eval::PoseList& initial,
                                            const std::map<int, PlacedBeacon>& placed);

/// Incremental, as on the vehicle: the last `window` poses are in the graph, older ones are
/// marginalised. A beacon is added when the finder has initialised it, with the finder's
/// covariance. Each pose is the live estimate.
[[nodiscard]] SlamEstimate solve_window(const SlamProblem& problem, const geometry::SE3& first,
                                        std::size_t window);

}  // namespace rali::ranges_bench
