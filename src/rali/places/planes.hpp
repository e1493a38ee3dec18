#pragma once

#include <span>
#include <vector>

#include "rali/geometry/types.hpp"

namespace rali::places {

/// What counts as a plane of a submap, and what its errors are (algorithms 2.3).
struct PlaneSettings {
  double cell_m =
      1.6;  ///< edge of the largest cells; split up to three times where they hold no plane
  int points_min = 8;
  double range_sigma_m = 0.02;
  double excess_max_m = 0.02;
  double excess_max_finest_m = 0.04;
  double width_min_ratio = 0.12;
  double sigma_floor_m = 0.004;
  double sigma_systematic_m = 0.01;
  double sigma_between_m = 0.005;

  template <class V>
  void visit(V& v) {
    v("cell_m", cell_m, 0.2, 5.0, "edge of the largest cells, split where they hold no plane");
    v("points_min", points_min, 5, 1000, "fewer points are no plane");
    v("range_sigma_m", range_sigma_m, 0.0, 1.0, "range noise taken out of the spread of points");
    v("excess_max_m", excess_max_m, 1e-3, 1.0, "thickness beyond range noise: more is split");
    v("excess_max_finest_m", excess_max_finest_m, 1e-3, 1.0,
      "the same in cells of the finest level");
    v("width_min_ratio", width_min_ratio, 0.0, 0.3,
      "smallest spread in the plane / edge of the cell");
    v("sigma_floor_m", sigma_floor_m, 1e-4, 0.1, "measured noise along the normal not below");
    v("sigma_systematic_m", sigma_systematic_m, 0.0, 0.1, "offset common to all points of a plane");
    v("sigma_between_m", sigma_between_m, 0.0, 0.1,
      "offset between the scans of a plane: it tilts it");
  }
};

/// A piece of surface with the covariance of its three parameters: tilts (n changes by a along e1,
/// by b along e2) and offset along n.
struct Plane {
  geometry::Vec3 q_m = geometry::Vec3::Zero();  ///< mean of its points
  geometry::Vec3 n = geometry::Vec3::UnitZ();   ///< unit, towards the sensor
  geometry::Vec3 e1 = geometry::Vec3::UnitX();
  geometry::Vec3 e2 = geometry::Vec3::UnitY();
  double var_tilt1 = 0.0;   ///< [rad^2]
  double var_tilt2 = 0.0;   ///< [rad^2]
  double var_offset = 0.0;  ///< [m^2], with the systematic part
  double var_noise = 0.0;   ///< [m^2], the part independent of other planes
  double radius_m = 0.0;    ///< half of the cell's diagonal: extent of validity
  int points = 0;

  /// Upright surfaces distinguish places; floors and ceilings are everywhere.
  [[nodiscard]] bool is_wall() const { return n.z() < 0.5 && n.z() > -0.5; }

  /// Variance of its height at q_m + d because of its tilts.
  [[nodiscard]] double tilt_variance_at(const geometry::Vec3& d) const {
    const double a1 = e1.dot(d);
    const double a2 = e2.dot(d);
    return a1 * a1 * var_tilt1 + a2 * a2 * var_tilt2;
  }

  [[nodiscard]] geometry::Mat3 normal_covariance() const {
    return var_tilt1 * e1 * e1.transpose() + var_tilt2 * e2 * e2.transpose();
  }
};

/// The planes of a cloud: cubes, split in eight (up to three times) where they hold more than one
/// plane.
/// @param points and @param rays (unit, from sensor to point) have equal length and are finite.
/// Ordered by cell, so that the result depends on the points alone.
[[nodiscard]] std::vector<Plane> planes_of(std::span<const geometry::Vec3f> points,
                                           std::span<const geometry::Vec3f> rays,
                                           const PlaneSettings& settings);

}  // namespace rali::places
