#include <cmath>
#include <numbers>

#include "rali/odometry/robust/internal/robust_filter.hpp"

namespace rali::odometry::internal {

/// The scan without the errors of its lasers, as far as they are known.
const sensor::LidarScan& RobustOdometry::corrected(const sensor::LidarScan& scan) {
  if (!scan.has_rings || lasers_now_.errors.empty()) return scan;
  corrected_ = scan;
  subtract_laser_errors(lasers_now_, corrected_);
  return corrected_;
}

/// Planes that were mapped from here by the same lasers say nothing about them.
/// @param scan corrected by lasers_now_
void RobustOdometry::measure_lasers(const sensor::LidarScan& scan) {
  constexpr double kGenerationsAgo = 4.0;
  if (!scan.has_rings) return;
  const double newest = drift_.epoch() - kGenerationsAgo;
  const geometry::Vec3 axis_body = calibration_.T_body_lidar.R.col(2);
  matcher_.visit(map_, state_.T_odom_body, [&](std::size_t k, const Matcher::Match& match) {
    if (!(match.epoch < newest)) return;
    const geometry::Vec3 rise = axis_body - axis_body.dot(match.ray_body) * match.ray_body;
    LaserResidual point;
    point.laser = scan.ring[sampler_.update_indices()[k]];
    point.per_elevation_m = match.range_m * match.n_body.dot(rise.normalized());
    point.per_range = match.n_body.dot(match.ray_body);
    const LaserError subtracted = lasers_now_.of(point.laser);
    point.residual_m = match.residual_m + point.per_elevation_m * subtracted.elevation_rad +
                       point.per_range * subtracted.range_m;
    point.weight = match.weight;
    lasers_.add(point);
  });
  const double before_radpm = tilt_rate().sigma_radpm;
  lasers_now_ = lasers_.calibration(prior_laser_sigma_rad());
  if (before_radpm > 0.0) scale_tilt(state_, tilt_rate().sigma_radpm / before_radpm);
}

double RobustOdometry::prior_laser_sigma_rad() const {
  return std::numbers::pi / 180.0 * settings_.drift.laser_sigma_deg;
}

TiltRate RobustOdometry::tilt_rate() const {
  return {settings_.drift.tilt_per_m * lasers_now_.elevation_sigma_rad,
          settings_.drift.tilt_length_m};
}

}  // namespace rali::odometry::internal
