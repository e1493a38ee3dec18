#include "rali/odometry/robust/laser_errors.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/LU>

namespace rali::odometry {

namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kDegree = std::numbers::pi / 180.0;

/// Errors of a plane are common to the points of many scans, so a laser is never better known than
/// this: those without errors show 0.001 to 0.026 degrees, with 1e5 points each.
constexpr double kCommon_rad = 0.02 * kDegree;
constexpr double kCommon_m = 0.004;

/// Sigma of ranges before any measurement. Data sheets state 2 to 3 cm for any point.
constexpr double kRangePrior_m = 0.01;

}  // namespace

LaserError LaserCalibration::of(std::uint16_t laser) const {
  return laser < errors.size() ? errors[laser] : LaserError{};
}

void LaserErrors::add(const LaserResidual& point) {
  if (point.laser >= lasers_.size()) lasers_.resize(point.laser + std::size_t{1});
  Laser& l = lasers_[point.laser];
  const Vector2d J(point.per_elevation_m, point.per_range);
  l.information += point.weight * J * J.transpose();
  l.weighted += point.weight * point.residual_m * J;
  ++l.points;
}

LaserCalibration LaserErrors::calibration(double prior_rad) const {
  LaserCalibration out{std::vector<LaserError>(lasers_.size()), prior_rad};
  const Matrix2d common = Vector2d(kCommon_rad * kCommon_rad, kCommon_m * kCommon_m).asDiagonal();
  Vector2d spread(prior_rad * prior_rad, kRangePrior_m * kRangePrior_m);
  // The second round has the spread of these lasers in place of the prior.
  for (int round = 0; round < 2; ++round) {
    const Matrix2d prior = spread.cwiseInverse().asDiagonal();
    Vector2d squares = Vector2d::Zero();
    double left_rad2 = 0.0;
    int seen = 0;
    for (std::size_t k = 0; k < lasers_.size(); ++k) {
      const Laser& l = lasers_[k];
      if (l.points == 0) continue;
      ++seen;
      const Matrix2d shrink = (Matrix2d::Identity() + l.information * common).inverse();
      const Matrix2d P = (shrink * l.information + prior).inverse();
      const Vector2d mean = P * shrink * l.weighted;
      out.errors[k] = {mean[0], mean[1]};
      squares += mean.cwiseAbs2() + P.diagonal();
      left_rad2 += P(0, 0);
    }
    if (seen == 0) return out;
    spread = squares / seen;
    out.elevation_sigma_rad = std::sqrt(left_rad2 / seen);
  }
  return out;
}

void subtract_laser_errors(const LaserCalibration& calibration, sensor::LidarScan& scan) {
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const LaserError error = calibration.of(scan.ring[i]);
    const float level_m2 = scan.x_m[i] * scan.x_m[i] + scan.y_m[i] * scan.y_m[i];
    if (!(level_m2 > 0.0F)) continue;
    const float level_m = std::sqrt(level_m2);
    const float range_m = std::sqrt(level_m2 + scan.z_m[i] * scan.z_m[i]);
    const auto down = static_cast<float>(error.elevation_rad);
    const float shorter = 1.0F - static_cast<float>(error.range_m) / range_m;
    const float level = shorter + down * scan.z_m[i] / level_m;
    scan.x_m[i] *= level;
    scan.y_m[i] *= level;
    scan.z_m[i] = shorter * scan.z_m[i] - down * level_m;
  }
}

}  // namespace rali::odometry
