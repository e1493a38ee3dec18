#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace rali::odometry {

/// Distance of a point from the plane that it lies on, and how errors of its laser change it.
struct LaserResidual {
  std::uint16_t laser = 0;
  double residual_m = 0.0;
  double per_elevation_m = 0.0;  ///< per radian of the laser's elevation
  double per_range = 0.0;        ///< per metre of its range
  double weight = 0.0;           ///< 1 / variance [1/m^2]
};

/// How far the elevations of the lasers are off, by the distances of each one's points from planes
/// that were seen from elsewhere: other lasers made these. What all lasers have in common does not
/// show. Each laser has an error of elevation and one of range; they are regressed together.
class LaserErrors {
 public:
  void add(const LaserResidual& point);

  /// Sigma of the elevation errors over the lasers: the root of the mean square of what is known of
  /// each, with `prior_rad` as the sigma of one that has not been measured (one step of empirical
  /// Bayes). @return prior_rad before any measurement
  [[nodiscard]] double elevation_sigma_rad(double prior_rad) const;

 private:
  /// Normal equations of elevation (e) and range (r).
  struct Laser {
    double ee_m2 = 0.0, er_m = 0.0, rr = 0.0;
    double e_m2 = 0.0, r_m = 0.0;
    std::size_t points = 0;
  };

  std::vector<Laser> lasers_;
};

}  // namespace rali::odometry
