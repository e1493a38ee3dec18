#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "rali/geometry/pca3.hpp"
#include "rali/geometry/types.hpp"

namespace rali::odometry {

/// Running sums of the points in a cell of the map, relative to its centre, for plane fitting.
struct PointSums {
  /// Points nearer to a face of the cell than this fraction of its edge measure the point density
  /// on that face.
  static constexpr double kShell = 0.125;

  int n = 0;
  /// Points that sample a new part of the surface. At standstill a sensor measures the same spots
  /// with each scan: that shows the noise of the points, not the surface between them.
  int samples = 0;
  std::uint64_t looked_at =
      0;  ///< bits of 4 x 4 x 4 parts: where rays passed nearest to the centre
  geometry::Vec3 sum = geometry::Vec3::Zero();
  // xx xy xz yy yz zz of the points, and of the unit rays that measured them
  double products[6] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  double epoch_sum = 0.0;  ///< of the generations (drift.hpp) of the points
  float rays[6] = {0.0F, 0.0F, 0.0F, 0.0F, 0.0F, 0.0F};
  /// Sums over the points near faces of s ray and of s ray p^T, row by row, where s is the
  /// component of the ray along the outward normal / thickness of the shell (noise_in()).
  float leaving[3] = {0.0F, 0.0F, 0.0F};
  float leaving_at[9] = {0.0F, 0.0F, 0.0F, 0.0F, 0.0F, 0.0F, 0.0F, 0.0F, 0.0F};

  /// @param p relative to the cell's centre [m]  @param ray unit  @param edge_m of the cell
  /// @param new_view the sensor has moved since the last view: each point is a sample
  void add(const geometry::Vec3& p, const geometry::Vec3f& ray, double epoch, double edge_m,
           bool new_view = true) {
    ++n;
    // Noise along the ray does not move the point of the ray that is nearest to the centre.
    const geometry::Vec3 r = ray.cast<double>();
    const std::uint64_t part = part_of(p - p.dot(r) * r, edge_m);
    if (new_view || (looked_at & part) == 0) ++samples;
    looked_at |= part;
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
    add_near_faces(p.cast<float>(), ray, static_cast<float>(edge_m));
  }

  /// Covariance of the measured points.
  [[nodiscard]] geometry::Mat3 covariance() const;

  /// Mean of ray ray^T.
  [[nodiscard]] geometry::Mat3 mean_ray_product() const;

  /// The part of covariance() that range noise has added.
  ///
  /// Noise e moves a point along its ray, to p. If the cell contains the whole surface, that adds
  /// E[e e^T]. If the point density is the same on both sides of a face, noise moves as many points
  /// in as out, and the position of a point is independent of its noise. Subtracting E[e e^T] from
  /// such a cell would tilt the surface towards the sensor. By Tweedie's formula (Efron 2011)
  /// E[e|p] = -S grad log f(p), with S = range_var ray ray^T and f the density of measured points.
  /// Over the cell, by parts: A = E[e p^T] = S (I - sum over faces of density normal p^T). The
  /// surface is at p - e, so A + A^T - E[e e^T] has been added; within the cell, E[e e^T] is the
  /// part that p explains, A C^-1 A^T.
  /// @param C covariance()
  [[nodiscard]] geometry::Mat3 noise_in(const geometry::Mat3& C, double range_var) const;

 private:
  static std::uint64_t part_of(const geometry::Vec3& p, double edge_m) {
    const auto along = [&p, edge_m](int k) {
      return std::clamp(static_cast<int>(4.0 / edge_m * p[k] + 2.0), 0, 3);
    };
    return std::uint64_t{1} << (16 * along(0) + 4 * along(1) + along(2));
  }

  void add_near_faces(const geometry::Vec3f& p, const geometry::Vec3f& ray, float edge_m) {
    const float inner_m = (0.5F - static_cast<float>(kShell)) * edge_m;
    float s = 0.0F;
    for (int k = 0; k < 3; ++k) {
      if (p[k] > inner_m) s += ray[k];
      if (p[k] < -inner_m) s -= ray[k];
    }
    if (s == 0.0F) return;
    s /= static_cast<float>(kShell) * edge_m;
    for (int i = 0; i < 3; ++i) {
      leaving[i] += s * ray[i];
      for (int j = 0; j < 3; ++j) leaving_at[3 * i + j] += s * ray[i] * p[j];
    }
  }
};

/// Limits for planes, and their errors (algorithms 2.3).
struct PlaneSettings {
  int points_min = 10;
  /// Range noise that is subtracted from the spread: RobustSettings::range_sigma_m, or as measured.
  double range_sigma_m = 0.02;
  /// Maximum thickness beyond what range noise explains; cells of the finest level may be rougher,
  /// since they cannot be split.
  double excess_max_m = 0.012;
  double excess_max_finest_m = 0.05;
  /// Used if scans cannot be undistorted (no point times): motion within a scan bends surfaces, and
  /// splitting them until they look flat only worsens their tilt.
  double excess_max_bent_m = 0.03;
  /// Minimum sqrt(l2), as a fraction of the cell's edge (a filled cell has 0.29): one ring is a
  /// line, and its small spread shows the errors of poses, not the surface.
  double width_min_ratio = 0.12;
  double sigma_floor_m = 0.003;      ///< lower bound of the noise along the normal
  double sigma_systematic_m = 0.01;  ///< common offset of all points of a plane
  double sigma_between_m =
      0.003;  ///< offset between the scans that filled a cell; it tilts the plane

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

/// A plane with the covariance of its three parameters: tilt about the axes (n rises by a along e1,
/// by b along e2) and offset c along n. Source: algorithms 2.3. It is valid within the extent of
/// its points; beyond them the same cell may contain another surface.
struct Plane {
  geometry::Vec3 q = geometry::Vec3::Zero();  ///< mean of its points [m]
  geometry::Vec3 n = geometry::Vec3::UnitZ();
  geometry::Vec3 e1 = geometry::Vec3::UnitX();
  geometry::Vec3 e2 = geometry::Vec3::UnitY();
  double var_tilt1 = 0.0;   ///< [rad^2], along e1
  double var_tilt2 = 0.0;   ///< [rad^2], along e2
  double var_offset = 0.0;  ///< [m^2]
  double reach1_m = 0.0;    ///< extent of its points from q along e1
  double reach2_m = 0.0;    ///< the same along e2
  double epoch = 0.0;       ///< mean generation of its points
  double var_normal = 0.0;  ///< measured noise of its points along n [m^2]

  /// The position is within the extent of its points.
  [[nodiscard]] bool reaches(const geometry::Vec3& from_q_m) const {
    return std::abs(e1.dot(from_q_m)) <= reach1_m && std::abs(e2.dot(from_q_m)) <= reach2_m;
  }
};

enum class FitResult {
  kPlane,
  kTooFew,   ///< points, or spread of points: more may make it a plane
  kTooThick  ///< the cell contains more than one plane
};

/// Fits a plane to the sums. @param origin of the sums, in the frame of the result.
/// @param edge_m of the cell. @param finest it cannot be split any more.
[[nodiscard]] FitResult fit_plane(const PointSums& sums, const geometry::Vec3& origin,
                                  double edge_m, bool finest, const PlaneSettings& settings,
                                  Plane& plane);

}  // namespace rali::odometry
