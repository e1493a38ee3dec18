#pragma once

#include <functional>

#include "rali/sim/builder.hpp"
#include "rali/sim/route.hpp"

namespace rali::sim {

/// Cross-section of a tube: flat floor, vertical walls, a semicircle above them; or a circle.
struct ArchShape {
  double half_width_m = 2.5;  ///< radius of the arch too
  double wall_m = 1.2;        ///< height of the vertical part
  bool round = false;         ///< a circle of this radius whose lowest point is on the axis
};

/// A point on the surface of a tube.
struct TubePoint {
  geometry::Vec3 p;      ///< in the world, before it is shifted
  double along_m = 0.0;  ///< of the axis
  double left_m = 0.0;   ///< from the axis
  double up_m = 0.0;     ///< above the floor
  bool floor = false;
};

using TubeShift = std::function<double(const TubePoint&)>;  ///< outward displacement [m]

/// Extrudes the section along an axis on the floor. Rows about every cell_m, `around` points each.
void add_tube(TriangleMesh& mesh, const Route& axis, const ArchShape& shape, double cell_m,
              int around, double refl, const TubeShift& shift);

/// Closes a tube: a wall of width 2 size_m across its end.
void add_tube_end(Builder& build, const geometry::Vec3& middle, double yaw_rad, double size_m,
                  std::uint64_t seed, double amplitude_m);

}  // namespace rali::sim
