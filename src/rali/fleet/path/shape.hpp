#pragma once

#include <vector>

#include "rali/base/settings.hpp"
#include "rali/geometry/se3.hpp"

namespace rali::fleet {

/// Constraints between successive nodes of a vehicle's path. In observable directions the shape of
/// the filter's path is kept: it was registered against the whole map, which a chain of relative
/// poses cannot improve. In degenerate directions it gives no constraint.
struct ShapeSettings {
  double known_m = 0.3;
  double known_rad = 0.05;
  double shape_m = 0.002;
  double shape_rad = 2e-4;
  double bend_radpm = 3e-4;  ///< of one place: its scans share the planes of the map
  double gap_m = 0.3;
  double loose_m = 0.01;
  double loose_rad = 1e-3;

  template <class V>
  void visit(V& v) {
    v("known_m", known_m, 1e-3, 100.0, "sigma of a scan from which a direction is degenerate");
    v("known_rad", known_rad, 1e-4, 10.0, "the same of a rotation");
    v("shape_m", shape_m, 1e-5, 1.0, "sigma of a step in observable directions: keeps the shape");
    v("shape_rad", shape_rad, 1e-6, 0.1, "the same of its turn");
    v("bend_radpm", bend_radpm, 0.0, 0.1,
      "sigma of how a passage turns the vehicle per metre that no scan sees");
    v("gap_m", gap_m, 1e-3, 100.0, "sigma of a step over a gap in the inertial data");
    v("loose_m", loose_m, 1e-4, 10.0,
      "steps with a larger sigma are also constrained by inertial data");
    v("loose_rad", loose_rad, 1e-5, 1.0, "the same of their turn");
  }
};

/// The observable fraction of a step: 1 where the LiDAR information is high, 0 where it is none.
/// @param lidar_information boxplus order, in odom
[[nodiscard]] geometry::Mat6 known_fraction(const geometry::Mat6& lidar_information,
                                            const ShapeSettings& settings);

/// Stiffness of a step of the path: the filter's step in observable directions, free in degenerate
/// ones. Rotation, then position in the body before (graph::RelativePoseFactor).
/// @param unseen_m2 position variance that the step has added in degenerate directions. The bend
/// there is uncertain and may rotate the step accordingly. The bend error is common to all steps of
/// a passage, so that variances of steps add up to that of the passage.
[[nodiscard]] geometry::Mat6 shape_information(const geometry::Mat6& lidar_information,
                                               const geometry::SE3& T_odom_before,
                                               const ShapeSettings& settings,
                                               double unseen_m2 = 0.0);

/// Added position variance of a step between two nodes of a filter's path, by their covariances
/// (boxplus).
[[nodiscard]] double unseen_variance_m2(const geometry::Mat6& covariance_before,
                                        const geometry::Mat6& covariance);

/// Whether the shape leaves a direction or a rotation of a step unconstrained.
[[nodiscard]] bool is_loose(const geometry::Mat6& lidar_information, const ShapeSettings& settings);

/// Variance of the position along a unit vector of odom, by a covariance of geometry::boxplus.
[[nodiscard]] double position_variance_m2(const geometry::Mat6& covariance,
                                          const geometry::Vec3& axis_odom);

/// A direction of odom in which a scan has found the map of earlier scans again.
struct Regained {
  geometry::Vec3 axis_odom;  ///< unit
  double variance_m2 = 0.0;  ///< of the position along it, then
};

/// Directions that the LiDAR observes at a node and in which the variance of the position has
/// fallen by much since the node before: by the LiDAR, not by ranges.
[[nodiscard]] std::vector<Regained> regained(const geometry::Mat6& covariance_before,
                                             const geometry::Mat6& covariance,
                                             const geometry::Mat6& lidar_information,
                                             const ShapeSettings& settings);

/// The least sigma of a step.
struct LeastSigma {
  double rad = 0.0, m = 0.0;
};

/// Adds the information of the filter's step by the growth of its covariance: a step is known no
/// better than the filter knows it, whose speed may be unknown.
void tie_by_filter(geometry::Mat6& shape, const geometry::Mat6& covariance_before,
                   const geometry::Mat6& covariance, const LeastSigma& least);

}  // namespace rali::fleet
