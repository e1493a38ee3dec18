#pragma once

#include "rali/geometry/se3.hpp"
#include "rali/sim/ray_caster.hpp"

namespace rali::sim {

/// Shape of a vehicle as seen by the LiDARs of the others: a box with an upright mast, both in the
/// body frame.
struct VehicleLook {
  geometry::Vec3 box_min_m{-0.30, -0.22, -0.20};
  geometry::Vec3 box_max_m{0.30, 0.22, 0.15};
  geometry::Vec2 mast_m{0.10, 0.0};  ///< x, y of its axis
  double mast_radius_m = 0.05;
  double mast_top_m = 0.42;
  float reflectivity = 0.35F;
};

/// Shortens `hit` if a vehicle of this shape at T_world_body intersects the ray before it.
void meet_vehicle(const VehicleLook& look, const geometry::SE3& T_world_body,
                  const geometry::Vec3& origin, const geometry::Vec3& direction, Hit& hit);

}  // namespace rali::sim
