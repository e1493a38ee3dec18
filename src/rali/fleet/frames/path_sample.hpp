#pragma once

#include "rali/base/time.hpp"
#include "rali/geometry/types.hpp"

namespace rali::fleet {

/// Position of a body or antenna in the odom frame of its vehicle, with the covariance from
/// odometry.
struct PathSample {
  Time t;
  geometry::Vec3 p_m = geometry::Vec3::Zero();
  geometry::Mat3 covariance_m2 = geometry::Mat3::Zero();
};

}  // namespace rali::fleet
