#pragma once

#include <functional>
#include <span>

#include "rali/geometry/types.hpp"

namespace rali::ranging {

/// Number of surfaces of a map between two points.
using SurfacesBetween = std::function<int(const geometry::Vec3&, const geometry::Vec3&)>;

/// Whether a point lies behind a surface for all of the places nearest to it; false if none is
/// near. All points in the frame of the map.
/// @param places_m where vehicles have been
[[nodiscard]] bool is_outside(const geometry::Vec3& p_m, std::span<const geometry::Vec3> places_m,
                              const SurfacesBetween& surfaces);

/// Whether a line leaves the space that vehicles have seen, as the chord of a bent tunnel does. It
/// crosses the walls at so grazing an angle that their crossings cannot be counted: an error of the
/// map by centimetres puts a wall on the line of sight of a straight tunnel.
[[nodiscard]] bool leaves_seen_space(const geometry::Vec3& p_m, const geometry::Vec3& q_m,
                                     const std::function<bool(const geometry::Vec3&)>& outside);

}  // namespace rali::ranging
