#pragma once

#include <span>

#include "rali/degeneracy/evidence.hpp"

namespace rali::degeneracy {

/// Planes that support a direction.
struct Support {
  int planes = 0;    ///< whose normals have a significant component along it
  int clusters = 0;  ///< of these planes, by position; counted up to kClustersMax
};

inline constexpr int kClustersMax = 8;

/// Whether a plane significantly constrains a direction: |n.d| > max(0.2, 3 sd of n.d).
/// @param along n.d  @param variance of n.d
[[nodiscard]] bool faces(double along, double variance);

/// Planes that face the direction, and the number of clusters they form. An end wall gives several
/// planes in several clusters; a single or moving object in a tunnel gives some in one.
/// @param direction_odom unit. @param cluster_m planes nearer than this to a cluster's first one
/// belong to it. The order of the planes affects only how clusters are cut.
/// Source: algorithms 3.2 and 3.6 (the rule that replaces N_d = 1).
[[nodiscard]] Support support_along(const geometry::Vec3& direction_odom,
                                    std::span<const PlaneEvidence> planes, double cluster_m);

}  // namespace rali::degeneracy
