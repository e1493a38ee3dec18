#pragma once

#include <vector>

#include "rali/geometry/types.hpp"

namespace rali::sim {

/// A path over the ground, points every kStep metres with rounded corners.
class Route {
 public:
  static constexpr double kStep_m = 0.05;

  /// @param corners  points on the ground, at least two different ones
  /// @param rounding_m  corners are cut over about this length
  Route(const std::vector<geometry::Vec3>& corners, double rounding_m);

  [[nodiscard]] double length_m() const { return s_m_.back(); }

  /// Point on the ground at arc length s [m] (clamped to the ends).
  [[nodiscard]] geometry::Vec3 point_at(double s_m) const;
  /// Horizontal heading [rad, unwrapped along the route] at arc length s [m].
  [[nodiscard]] double yaw_at(double s_m) const;
  /// dz/ds at arc length s [m].
  [[nodiscard]] double slope_at(double s_m) const;
  /// Change of heading per metre.
  [[nodiscard]] double curvature_at(double s_m) const;

 private:
  [[nodiscard]] double sample(const std::vector<double>& values, double s_m) const;

  std::vector<double> x_, y_, z_, yaw_, s_m_, slope_;
};

}  // namespace rali::sim
