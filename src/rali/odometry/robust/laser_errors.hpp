#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "rali/sensor/lidar_scan.hpp"

namespace rali::odometry {

/// Distance of a point from the plane that it lies on, and how errors of its laser change it.
struct LaserResidual {
  std::uint16_t laser = 0;
  double residual_m = 0.0;
  double per_elevation_m = 0.0;  ///< per radian of the laser's elevation
  double per_range = 0.0;        ///< per metre of its range
  double weight = 0.0;           ///< 1 / variance [1/m^2]
};

/// What a laser reports too much.
struct LaserError {
  double elevation_rad = 0.0;
  double range_m = 0.0;
};

/// Errors of all lasers as far as they are known.
struct LaserCalibration {
  std::vector<LaserError> errors;    ///< by laser; zero for one that has not been measured
  double elevation_sigma_rad = 0.0;  ///< of what is left over once they are subtracted

  /// Of a laser, zero for one that is not in `errors`.
  [[nodiscard]] LaserError of(std::uint16_t laser) const;
};

/// The points as they were without these errors, turned about the scan's origin and moved along
/// their rays.
void subtract_laser_errors(const LaserCalibration& calibration, sensor::LidarScan& scan);

/// How far the elevations and ranges of the lasers are off, by the distances of each one's points
/// from planes that were seen from elsewhere: other lasers made these. What all lasers have in
/// common does not show.
class LaserErrors {
 public:
  void add(const LaserResidual& point);

  /// Each laser by what its points show and by the spread of all lasers (empirical Bayes).
  /// @param prior_rad sigma of the elevations before any measurement
  [[nodiscard]] LaserCalibration calibration(double prior_rad) const;

 private:
  /// Normal equations of elevation [rad] and range [m].
  struct Laser {
    Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
    Eigen::Vector2d weighted = Eigen::Vector2d::Zero();
    std::size_t points = 0;
  };

  std::vector<Laser> lasers_;
};

}  // namespace rali::odometry
