#pragma once

#include "rali/geometry/se3.hpp"

namespace rali::fleet {

/// The frame in which start poses are measured: at a body's first pose, z against gravity, x along
/// the heading of the body. @param up_odom unit vector against gravity
[[nodiscard]] geometry::SE3 level_start(const geometry::SE3& T_odom_first,
                                        const geometry::Vec3& up_odom);

}  // namespace rali::fleet
