#pragma once

#include "rali/geometry/types.hpp"

namespace rali::ranging {

/// The walls on both sides of a point in a passage.
struct PassageWalls {
  geometry::Vec3 axis = geometry::Vec3::UnitX();  ///< of the passage; level, unit, either sign
  double left_m = 0.0;                            ///< to the wall on the side of up x axis
  double right_m = 0.0;
};

}  // namespace rali::ranging
