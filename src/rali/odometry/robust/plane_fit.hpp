#pragma once

#include "rali/geometry/pca3.hpp"
#include "rali/geometry/types.hpp"

namespace rali::odometry {

/// Running sums of points, relative to an origin near them, for plane fitting.
struct PointSums {
  int n = 0;
  geometry::Vec3 sum = geometry::Vec3::Zero();
  // xx xy xz yy yz zz of the points, and of the unit rays that measured them
  double products[6] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  double epoch_sum = 0.0;  ///< of the generations (drift.hpp) in which the points came
  float rays[6] = {0.0F, 0.0F, 0.0F, 0.0F, 0.0F, 0.0F};

  void add(const geometry::Vec3& p, const geometry::Vec3f& ray, double epoch) {
    ++n;
    epoch_sum += epoch;
    sum += p;
    products[0] += p.x() * p.x();
    products[1] += p.x() * p.y();
    products[2] += p.x() * p.z();
    products[3] += p.y() * p.y();
    products[4] += p.y() * p.z();
    products[5] += p.z() * p.z();
    rays[0] += ray.x() * ray.x();
    rays[1] += ray.x() * ray.y();
    rays[2] += ray.x() * ray.z();
    rays[3] += ray.y() * ray.y();
    rays[4] += ray.y() * ray.z();
    rays[5] += ray.z() * ray.z();
  }

  /// Covariance of the points as measured.
  [[nodiscard]] geometry::Mat3 covariance() const;

  /// Mean of ray ray^T: times the range variance, what range noise adds to covariance().
  [[nodiscard]] geometry::Mat3 mean_ray_product() const;
};

/// Limits for what counts as a plane and what its errors are (algorithms 2.3).
struct PlaneSettings {
  int points_min = 10;
  /// Range noise whose part in the spread is taken out: RobustSettings::range_sigma_m, or as
  /// measured.
  double range_sigma_m = 0.02;
  /// Thickness beyond what range noise explains, at most; cells of the finest level may be
  /// rougher, since they cannot be split.
  double excess_max_m = 0.012;
  double excess_max_finest_m = 0.05;
  /// While sweeps cannot be undistorted (no point times): surfaces are bent by the motion within
  /// a sweep, and splitting them until they look flat only makes their tilt worse.
  double excess_max_bent_m = 0.03;
  /// sqrt(l2) at least, as a share of the cell's edge (a filled cell has 0.29): one ring is a
  /// line, and what little it spreads shows the errors of poses, not the surface.
  double width_min_ratio = 0.12;
  double sigma_floor_m = 0.003;      ///< measured noise along the normal not below
  double sigma_systematic_m = 0.01;  ///< common offset of all points of a plane
  double sigma_between_m = 0.003;    ///< offset between the scans that filled a cell: tilts it

  template <class V>
  void visit(V& v) {
    v("points_min", points_min, 5, 1000, "fewer points are no plane");
    v("excess_max_m", excess_max_m, 1e-3, 1.0, "thickness beyond range noise: more is split");
    v("excess_max_finest_m", excess_max_finest_m, 1e-3, 1.0,
      "the same in cells of the finest level");
    v("excess_max_bent_m", excess_max_bent_m, 1e-3, 1.0,
      "thickness beyond range noise while scans cannot be undistorted");
    v("width_min_ratio", width_min_ratio, 0.0, 0.3,
      "smallest spread in the plane / edge of the cell");
    v("sigma_floor_m", sigma_floor_m, 1e-4, 0.1, "measured noise along the normal not below");
    v("sigma_systematic_m", sigma_systematic_m, 0.0, 0.1, "offset common to all points of a plane");
    v("sigma_between_m", sigma_between_m, 0.0, 0.1,
      "offset between scans within a plane: its tilt");
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
  double epoch = 0.0;       ///< mean generation of its points
  double var_normal = 0.0;  ///< measured noise of its points along n [m^2]
};

enum class FitResult {
  kPlane,
  kTooFew,   ///< points, or spread of points: more may make it a plane
  kTooThick  ///< something else than one plane is in the cell
};

/// Fits a plane to the sums. @param origin of the sums, in the frame of the result.
/// @param edge_m of the cell. @param finest it cannot be split any more.
[[nodiscard]] FitResult fit_plane(const PointSums& sums, const geometry::Vec3& origin,
                                  double edge_m, bool finest, const PlaneSettings& settings,
                                  Plane& plane);

}  // namespace rali::odometry
