#pragma once

#include <vector>

#include "rali/base/rng.hpp"
#include "rali/fleet/frames/pair_track.hpp"
#include "rali/fleet/frames/yaw_pose.hpp"

namespace rali::frames_bench {

/// Error parameters of the simulated odometry.
struct DriveErrors {
  double scale = 0.005;              ///< sd per run
  double yaw_deg_per_sqrt_m = 0.05;  ///< random walk
};

/// One vehicle's path in the plane, true and by odometry. Both are in the odom frame, which
/// coincides with the true one at the first point.
struct Drive {
  std::vector<geometry::Vec2> true_m, odom_m;
};

/// The path through these corners at constant speed, as n points.
[[nodiscard]] std::vector<geometry::Vec2> way_through(const std::vector<geometry::Vec2>& corners,
                                                      std::size_t n);

/// Simulated odometry of a path.
[[nodiscard]] Drive drive_along(const std::vector<geometry::Vec2>& path, const DriveErrors& errors,
                                Rng& rng);

/// Range k between two drives: the antenna positions by odometry, the true range plus `bias_m` and
/// noise.
[[nodiscard]] fleet::RangeObservation observe(const Drive& a, const Drive& b,
                                              const fleet::YawPose& T_b_a, std::size_t k,
                                              double t_s, double bias_m, double sigma_m, Rng& rng);

/// Root mean square, median and maximum of a column of numbers.
[[nodiscard]] double rms(const std::vector<double>& values);
[[nodiscard]] double median(std::vector<double> values);
[[nodiscard]] double largest(const std::vector<double>& values);

}  // namespace rali::frames_bench
