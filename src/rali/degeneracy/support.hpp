#pragma once

#include <span>

#include "rali/degeneracy/evidence.hpp"

namespace rali::degeneracy {

/// What holds a direction beyond doubt.
struct Support {
  int planes = 0;    ///< whose normals point along it, by more than chance
  int clusters = 0;  ///< of these planes, apart from each other; counted up to kClustersMost
};

inline constexpr int kClustersMost = 8;

/// Whether a plane constrains a direction by more than chance: |n.d| > max(0.2, 3 sd of n.d).
/// @param along n.d  @param variance of n.d
[[nodiscard]] bool faces(double along, double variance);

/// Planes that face the direction, and in how many places they are: a wall's end gives
/// several in several places, what stands or drives alone in a tunnel gives some in one.
/// @param direction_odom unit. @param cluster_m planes nearer than this to a cluster's first one
/// belong to it. Depends on the order of the planes only in how clusters are cut.
/// Source: algorithms 3.2 and 3.6 (the rule that replaces N_d = 1).
[[nodiscard]] Support support_along(const geometry::Vec3& direction_odom,
                                    std::span<const PlaneEvidence> planes, double cluster_m);

}  // namespace rali::degeneracy
