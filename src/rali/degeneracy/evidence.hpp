#pragma once

#include "rali/geometry/types.hpp"

namespace rali::degeneracy {

/// Constraint that the points on one plane of the map put on the pose.
struct PlaneEvidence {
  geometry::Vec3 n_odom = geometry::Vec3::Zero();        ///< unit normal
  geometry::Vec3 lever_odom_m = geometry::Vec3::Zero();  ///< from the body to the points' centre
  geometry::Mat3 normal_covariance = geometry::Mat3::Zero();  ///< of n_odom [rad^2]
  double weight = 0.0;      ///< information along the normal [1/m^2], errors of the plane included
  double residual_m = 0.0;  ///< mean signed distance of the points from the plane, along n_odom
  int points = 0;
};

}  // namespace rali::degeneracy
