#pragma once

#include <map>
#include <vector>

#include "slam_placing.hpp"

namespace rali::ranges_bench {

/// How ranges differed from what the graph expected before it used them.
struct Innovations {
  std::size_t count = 0, beyond = 0;  ///< beyond: normalised square above 10.83, 0.1 % if honest
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

/// All poses and ranges at once in a graph::PoseGraph, nothing marginalised. Beacons begin where
/// `placed` says with a prior of 1 km. Ranges hang on their poses.
[[nodiscard]] SlamEstimate solve_batch(const SlamProblem& problem, const eval::PoseList& initial,
                                       const std::map<int, geometry::Vec3>& placed);

/// solve_batch() from where the beacons were placed; a single one that was not certain is also
/// begun in eight directions around the first range to it. To known points: from several places of
/// the frame (place_frame). The lowest cost is the answer.
[[nodiscard]] SlamEstimate solve_batch_from(const SlamProblem& problem,
                                            const eval::PoseList& initial,
                                            const std::map<int, PlacedBeacon>& placed);

/// As the vehicle would: pose after pose, the last `window` of them in the graph, the oldest
/// marginalised; a beacon joins when the finder has it, with the finder's covariance. Each pose is
/// as it was known when it came.
[[nodiscard]] SlamEstimate solve_window(const SlamProblem& problem, const geometry::SE3& first,
                                        std::size_t window);

}  // namespace rali::ranges_bench
