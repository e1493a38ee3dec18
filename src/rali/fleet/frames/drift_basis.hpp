#pragma once

#include <vector>

#include <Eigen/Core>

#include "rali/base/time.hpp"
#include "rali/fleet/frames/settings.hpp"
#include "rali/geometry/types.hpp"

namespace rali::fleet {

/// Where an antenna was, in the odom frame of its vehicle, with what odometry tells of its error.
struct PathSample {
  Time t;
  geometry::Vec3 p_m = geometry::Vec3::Zero();
  geometry::Mat3 covariance_m2 = geometry::Mat3::Zero();
};

/// Errors of a path as few independent numbers of unit variance: column k is the displacement at a
/// sample if number k is 1. They are: the scale, tilt about x and y, the heading of each piece of
/// the path, and per piece the axes by which the told covariance grows. So errors of odometry stay
/// correlated along the way, which a sigma added to each range would not be (algorithms_fleet 7.4,
/// step 3: C_odo). All vanish at the earliest sample: the frame is the one odometry had there.
///
/// @return one 3xM matrix per sample, in the order given; M is the same for all
[[nodiscard]] std::vector<Eigen::Matrix3Xd> drift_basis(const std::vector<PathSample>& path,
                                                        const DriftSettings& settings);

}  // namespace rali::fleet
