#include "rali/odometry/robust/laser_errors.hpp"

#include <cmath>
#include <numbers>

namespace rali::odometry {

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

/// Errors of a plane are common to the points of many scans, so an elevation is never better known
/// than this: lasers without errors show 0.001 to 0.026 degrees, with 1e5 points each.
constexpr double kCommon_rad = 0.02 * kDegree;

}  // namespace

void LaserErrors::add(const LaserResidual& point) {
  if (point.laser >= lasers_.size()) lasers_.resize(point.laser + std::size_t{1});
  Laser& l = lasers_[point.laser];
  l.ee_m2 += point.weight * point.per_elevation_m * point.per_elevation_m;
  l.er_m += point.weight * point.per_elevation_m * point.per_range;
  l.rr += point.weight * point.per_range * point.per_range;
  l.e_m2 += point.weight * point.per_elevation_m * point.residual_m;
  l.r_m += point.weight * point.per_range * point.residual_m;
  ++l.points;
}

double LaserErrors::elevation_sigma_rad(double prior_rad) const {
  double squares_rad2 = 0.0;
  std::size_t seen = 0;
  for (const Laser& l : lasers_) {
    if (l.points == 0) continue;
    ++seen;
    const double coupled = l.rr > 0.0 ? l.er_m / l.rr : 0.0;
    const double information = l.ee_m2 - coupled * l.er_m;  // of the elevation, range unknown
    if (!(information > 0.0)) {
      squares_rad2 += prior_rad * prior_rad;
      continue;
    }
    const double error_rad = (l.e_m2 - coupled * l.r_m) / information;
    const double variance_rad2 = 1.0 / information + kCommon_rad * kCommon_rad;
    const double trust = prior_rad * prior_rad / (prior_rad * prior_rad + variance_rad2);
    squares_rad2 += trust * trust * error_rad * error_rad + trust * variance_rad2;
  }
  if (seen == 0) return prior_rad;
  return std::sqrt(squares_rad2 / static_cast<double>(seen));
}

}  // namespace rali::odometry
