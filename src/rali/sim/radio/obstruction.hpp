#pragma once

#include <span>

#include "rali/geometry/types.hpp"
#include "rali/sim/ray_caster.hpp"

namespace rali::sim {

/// A vehicle or person that may obstruct a signal: an upright cylinder.
struct RadioBody {
  geometry::Vec3 foot_m = geometry::Vec3::Zero();  ///< centre of its lower end, world
  double radius_m = 0.3;
  double height_m = 1.7;
};

/// Obstacles between two antennas.
struct Obstruction {
  int walls = 0;             ///< solid pieces crossed
  double thickness_m = 0.0;  ///< of all of them along the line
  int bodies = 0;            ///< vehicles and persons crossed

  [[nodiscard]] bool clear() const { return walls == 0 && bodies == 0; }
};

/// Traces the straight line from a to b (world). Antennas are outside of solids, so the line
/// crosses surfaces in pairs: into a solid and out of it. An odd number means that one surface is a
/// sheet. Then surfaces less than half a metre apart are pairs, all others sheets of
/// `sheet_thickness_m`. Counting ends after 32 surfaces.
[[nodiscard]] Obstruction trace_line(const RayCaster& world, const geometry::Vec3& a,
                                     const geometry::Vec3& b, double sheet_thickness_m,
                                     std::span<const RadioBody> bodies = {});

}  // namespace rali::sim
