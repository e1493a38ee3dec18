#pragma once

#include <vector>

#include "rali/base/rng.hpp"
#include "rali/fleet/frames/pair_track.hpp"
#include "rali/fleet/frames/yaw_pose.hpp"

namespace rali::frames_bench {

/// How the simulated odometry errs.
struct DriveErrors {
  double scale = 0.005;              ///< sd per run
  double yaw_deg_per_sqrt_m = 0.05;  ///< random walk
};

/// One vehicle's way in the plane: where it was and where its odometry says it was, both in the
/// odom frame, which is the true one at the first point.
struct Drive {
  std::vector<geometry::Vec2> true_m, odom_m;
};

/// The way through these corners at constant speed, as n points.
[[nodiscard]] std::vector<geometry::Vec2> way_through(const std::vector<geometry::Vec2>& corners,
                                                      std::size_t n);

/// What odometry makes of a way.
[[nodiscard]] Drive drive_along(const std::vector<geometry::Vec2>& way, const DriveErrors& errors,
                                Rng& rng);

/// Range k between two drives: the antennas as odometry has them, the range as it truly is plus
/// `bias_m` and noise.
[[nodiscard]] fleet::RangeObservation observe(const Drive& a, const Drive& b,
                                              const fleet::YawPose& T_b_a, std::size_t k,
                                              double t_s, double bias_m, double sigma_m, Rng& rng);

/// Root of the mean of squares, share and the like of a column of numbers.
[[nodiscard]] double rms(const std::vector<double>& values);
[[nodiscard]] double median(std::vector<double> values);
[[nodiscard]] double largest(const std::vector<double>& values);

}  // namespace rali::frames_bench
