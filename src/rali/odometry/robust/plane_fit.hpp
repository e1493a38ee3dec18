#pragma once

#include "rali/geometry/pca3.hpp"
#include "rali/geometry/types.hpp"

namespace rali::odometry {

/// Running sums of points, relative to an origin near them, for plane fitting.
struct PointSums {
  int n = 0;
  geometry::Vec3 sum = geometry::Vec3::Zero();
  // xx xy xz yy yz zz
  double products[6] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};

  void add(double x, double y, double z) {
    ++n;
    sum += geometry::Vec3(x, y, z);
    products[0] += x * x;
    products[1] += x * y;
    products[2] += x * z;
    products[3] += y * y;
    products[4] += y * z;
    products[5] += z * z;
  }

  [[nodiscard]] geometry::Mat3 covariance() const;
};

/// Limits for what counts as a plane and what its errors are (algorithms 2.3).
struct PlaneSettings {
  int points_min = 10;
  double thickness_max_m = 0.06;   ///< sqrt(l3) at most
  double width_min_m = 0.04;       ///< sqrt(l2) at least: a line of one ring is no plane
  double sigma_floor_m = 0.003;    ///< measured noise along the normal not below
  double sigma_systematic_m = 0.01;  ///< common offset of all points of a plane
  double tilt_systematic_rad = 0.002;  ///< common tilt

  template <class V>
  void visit(V& v) {
    v("points_min", points_min, 5, 1000, "fewer points are no plane");
    v("thickness_max_m", thickness_max_m, 0.005, 1.0, "largest spread along the normal");
    v("width_min_m", width_min_m, 0.005, 1.0, "smallest spread in the plane: one ring is a line");
    v("sigma_floor_m", sigma_floor_m, 1e-4, 0.1, "measured noise along the normal not below");
    v("sigma_systematic_m", sigma_systematic_m, 0.0, 0.1, "offset common to all points of a plane");
    v("tilt_systematic_rad", tilt_systematic_rad, 0.0, 0.1, "tilt common to all points of a plane");
  }
};

/// A plane with the covariance of its three parameters: tilt about the axes (n rises by a along
/// e1, by b along e2) and offset c along n. Source: algorithms 2.3.
struct Plane {
  geometry::Vec3 q = geometry::Vec3::Zero();  ///< mean of its points [m]
  geometry::Vec3 n = geometry::Vec3::UnitZ();
  geometry::Vec3 e1 = geometry::Vec3::UnitX();
  geometry::Vec3 e2 = geometry::Vec3::UnitY();
  double var_tilt1 = 0.0;   ///< [rad^2], along e1
  double var_tilt2 = 0.0;   ///< [rad^2], along e2
  double var_offset = 0.0;  ///< [m^2]
  double var_normal = 0.0;  ///< measured noise of its points along n [m^2]
};

/// Fits a plane to the sums. @param origin of the sums, in the frame of the result.
/// @return false if the points are no plane.
[[nodiscard]] bool fit_plane(const PointSums& sums, const geometry::Vec3& origin,
                             const PlaneSettings& settings, Plane& plane);

}  // namespace rali::odometry
