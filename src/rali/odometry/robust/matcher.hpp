#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "rali/geometry/se3.hpp"
#include "rali/odometry/deskew.hpp"
#include "rali/odometry/odometry.hpp"
#include "rali/odometry/robust/plane_map.hpp"

namespace rali::odometry {

/// Noise of one LiDAR point and the treatment of outliers (algorithms 2.3, 2.4).
struct MatchSettings {
  double range_sigma_m = 0.02;  ///< RobustSettings::range_sigma_m, or as measured
  double beam_sigma_rad = 0.0017;
  double rough_sigma_m = 0.01;
  double cauchy_scale = 3.0;
  double gate_sigma = 3.0;
  double gate_min_m = 0.05;
  double gate_max_m = 1.0;

  template <class V>
  void visit(V& v) {
    v("beam_sigma_rad", beam_sigma_rad, 0.0, 0.1, "noise of a beam's direction");
    v("rough_sigma_m", rough_sigma_m, 0.0, 1.0, "roughness of surfaces");
    v("cauchy_scale", cauchy_scale, 0.5, 100.0, "knee of the robust weight, in sigma");
    v("gate_sigma", gate_sigma, 1.0, 20.0, "farther points are no match, in sigma");
    v("gate_min_m", gate_min_m, 0.0, 1.0, "the gate is never narrower");
    v("gate_max_m", gate_max_m, 0.05, 10.0, "the gate is never wider");
  }
};

/// Gauss-Newton system of one iteration in boxplus order (rotation, position). The error of a plane
/// counts once for all of its points (algorithms 2.4).
struct LidarSystem {
  geometry::Mat6 I = geometry::Mat6::Zero();
  geometry::Vec6 b = geometry::Vec6::Zero();
  int matches = 0;
  double residual_sum2_m2 = 0.0;  ///< of matched points, robustly weighted
  double weight_sum = 0.0;
  double mean_epoch = 0.0;  ///< of the matched planes, weighted by their information
};

/// Information on the position along a direction, from points on established planes that face it
/// (degeneracy::faces) [1/m^2].
struct Hold {
  double here = 0.0;
  double elsewhere = 0.0;  ///< the same with the pose a step ahead or behind: the larger
};

/// Which planes may match a point.
enum class Reach {
  kNear,    ///< the nearest, in this cell or the next: the guess may be half a cell off
  kCell,    ///< the plane of its cell
  kPoints,  ///< the plane of its cell, within the extent of its points only
};

/// Points of a scan where the map has planes.
struct Overlap {
  int within = 0;
  int on = 0;  ///< the planes

  [[nodiscard]] int beside() const { return within - on; }

  /// Fraction of them on the planes; 0 without any.
  [[nodiscard]] double agreement() const {
    return within > 0 ? static_cast<double>(on) / within : 0.0;
  }
};

/// Matches the points of a scan with the planes of the map and sums their information.
class Matcher {
 public:
  explicit Matcher(const MatchSettings& settings) : settings_(settings) {}

  void set_range_sigma(double sigma_m) { settings_.range_sigma_m = sigma_m; }

  /// Sets the points of the scan (body frame); `p_body_lidar` is the origin of the rays.
  void set_points(const BodyPoints& points, const geometry::Vec3& p_body_lidar);

  [[nodiscard]] std::size_t size() const { return points_.size(); }

  /// Finds a plane for each point. @param P_pose covariance of the pose, for the gate.
  void match(const PlaneMap& map, const geometry::SE3& T_odom_body, const geometry::Mat6& P_pose,
             Reach reach);

  /// Points of the scan that lie within the extent of a plane of their cell, and those of them that
  /// lie on it; unseen places count for nothing.
  [[nodiscard]] Overlap overlap(const PlaneMap& map, const geometry::SE3& T_odom_body) const;

  /// Sums residuals at the given pose over the matches of the last match().
  [[nodiscard]] LidarSystem accumulate(const PlaneMap& map, const geometry::SE3& T_odom_body);

  /// Information of each plane in the last accumulate().
  [[nodiscard]] const std::vector<degeneracy::PlaneEvidence>& evidence() const { return evidence_; }

  /// Mean generation (drift.hpp) of the planes that constrain a translation, as of the last
  /// accumulate(); nothing: no plane does. The uncertainty of normals is subtracted.
  /// @param d_odom unit vector
  [[nodiscard]] std::optional<double> mean_epoch(const geometry::Vec3& d_odom) const;

  /// One matched point of the scan.
  struct Match {
    geometry::Vec3 n_body, ray_body;  ///< normal of its plane, and its ray
    double range_m = 0.0;
    double residual_m = 0.0;  ///< from the plane, along the normal
    double weight = 0.0;      ///< 1 / variance, plane included, robust [1/m^2]
    double epoch = 0.0;       ///< mean generation of the plane's points
  };

  /// Calls visitor(k, match) for each matched point k of set_points(), as of the last match().
  template <class Visitor>
  void visit(const PlaneMap& map, const geometry::SE3& T_odom_body, Visitor&& visitor) const {
    for (std::size_t k = 0; k < points_.size(); ++k) {
      if (points_[k].plane >= 0) visitor(k, match_of(points_[k], map, T_odom_body));
    }
  }

  /// Number of points matched to planes that face a direction. @param d_odom unit vector
  [[nodiscard]] std::size_t points_facing(const PlaneMap& map, const geometry::Vec3& d_odom) const;

  /// Of the matches of the last match(), and again a step ahead and a step behind.
  /// @param d_odom unit vector @param newest_epoch planes of later generations are not established
  [[nodiscard]] Hold hold_along(const PlaneMap& map, const geometry::SE3& T_odom_body,
                                const geometry::Vec3& d_odom, double step_m,
                                double newest_epoch) const;

 private:
  /// Weighted moments of the points of one plane: sum w [p;1][p;1]^T, upper triangle.
  struct Group {
    int plane = -1;
    int points = 0;
    double m[10] = {};
  };

  struct Point {
    float x, y, z;     // body
    float dx, dy, dz;  // unit ray in body
    float range2_m2;   // squared
    int plane = -1;

    [[nodiscard]] geometry::Vec3 p_body() const { return geometry::Vec3f(x, y, z).cast<double>(); }

    [[nodiscard]] geometry::Vec3 ray_body() const {
      return geometry::Vec3f(dx, dy, dz).cast<double>();
    }
  };

  /// A plane relative to the body: a point p of the body lies c + n.p above it.
  struct PlaneInBody {
    geometry::Vec3 n, e1, e2;  // body
    geometry::Vec3 n_odom;
    double c_m, c1_m, c2_m;  // along n, e1, e2
    double var_tilt1, var_tilt2, var_offset;
  };

  static void add_point(const Group& group, const PlaneInBody& plane, LidarSystem& system);
  static void add_moments(const Group& group, const PlaneInBody& plane, LidarSystem& system);

  [[nodiscard]] Match match_of(const Point& point, const PlaneMap& map,
                               const geometry::SE3& T_odom_body) const;
  [[nodiscard]] double hold_of(const Point& point, const Plane& plane, const geometry::Vec3& x_odom,
                               const geometry::Vec3& d_odom, const geometry::Vec3& ray_odom) const;
  [[nodiscard]] double point_variance(const Point& p, double cos_incidence,
                                      double plane_var_m2) const;
  void add_group(const Group& group, const PlaneMap& map, const geometry::SE3& T_odom_body,
                 LidarSystem& system);

  MatchSettings settings_;
  std::vector<Point> points_;
  std::vector<Group> groups_;
  std::vector<int> group_of_plane_;  ///< by plane index, -1 = none yet
  std::vector<degeneracy::PlaneEvidence> evidence_;
  std::vector<double> epochs_;  ///< of the planes of evidence_
};

}  // namespace rali::odometry
