#pragma once

#include <vector>

#include <Eigen/Core>

#include "rali/base/time.hpp"
#include "rali/fleet/frames/settings.hpp"
#include "rali/geometry/types.hpp"

namespace rali::fleet {

/// Position of an antenna in the odom frame of its vehicle, with the covariance from odometry.
struct PathSample {
  Time t;
  geometry::Vec3 p_m = geometry::Vec3::Zero();
  geometry::Mat3 covariance_m2 = geometry::Mat3::Zero();
};

/// Errors of a path as few independent parameters of unit variance: column k is the displacement of
/// a sample if parameter k is 1. Parameters are: the scale, tilt about x and y, the heading of each
/// segment of the path, and per segment the axes along which the reported covariance grows. So
/// odometry errors stay correlated along the path, which a sigma added to each range would not
/// model (algorithms_fleet 7.4, step 3: C_odo). All vanish at the earliest sample, where the odom
/// frame is defined.
///
/// @return one 3xM matrix per sample, in the order given; M is the same for all
[[nodiscard]] std::vector<Eigen::Matrix3Xd> drift_basis(const std::vector<PathSample>& path,
                                                        const DriftSettings& settings);

}  // namespace rali::fleet
