#pragma once

#include <span>

#include "rali/degeneracy/evidence.hpp"
#include "rali/geometry/se3.hpp"

namespace rali::degeneracy {

/// What the walls that face a motion say about it.
struct WallHold {
  double raw = 0.0;         ///< information before noise removal [1/m^2]
  double noise = 0.0;       ///< what the noise of their normals alone is expected to give
  double residual_m = 0.0;  ///< mean distance of the points from the walls, along the motion
};

/// Information of the walls that face a motion, apart from all other planes. From the middle of a
/// corridor, its end walls are a dozen planes of some points each, among a thousand whose normals
/// face the motion by their errors only: the sum of these errors exceeds what the end walls say,
/// however exact that is (algorithms 3.2). One plane of the thousand may face the motion by a wrong
/// normal, e.g. fitted to points of one ring across the roof. So a wall is several planes that lie
/// in one.
/// @param motion boxplus order (least_motion())
[[nodiscard]] WallHold walls_facing(const geometry::Vec6& motion,
                                    std::span<const PlaneEvidence> planes,
                                    const geometry::Mat3& R_odom_body);

}  // namespace rali::degeneracy
