#pragma once

#include <cstdint>
#include <vector>

#include "rali/geometry/types.hpp"

namespace rali::map {

/// Points of the map: flat arrays of equal length.
struct MapCloud {
  /// Added to x, y, z gives coordinates in map. Zero unless the map lies so far out (4 km) that
  /// float32 would have visible steps; then whole kilometres.
  geometry::Vec3 origin_map_m = geometry::Vec3::Zero();
  std::vector<float> x_m, y_m, z_m;
  std::vector<float> intensity;       ///< mean
  std::vector<float> sigma_m;         ///< root of the expected squared 3-D position error
  std::vector<std::uint16_t> seen;    ///< keyframes that saw it (65535 = that or more)
  std::vector<std::uint8_t> vehicle;  ///< vehicle that saw it first

  [[nodiscard]] std::size_t size() const { return x_m.size(); }
};

}  // namespace rali::map
