#pragma once

#include <cstdint>
#include <vector>

#include "rali/base/ids.hpp"
#include "rali/geometry/types.hpp"

namespace rali::map {

/// State of a frontier that persists between updates and between anchors.
struct NamedFrontier {
  std::uint32_t id = 0;  ///< from 1; constant for the frontier's life
  geometry::Vec2 centre_map_m = geometry::Vec2::Zero();
  double size = 0.0;         ///< by FrontierSettings::size
  std::uint32_t visits = 0;  ///< that changed nothing

  bool operator==(const NamedFrontier&) const = default;
};

/// A position to which a vehicle was sent without finding a path.
struct NoPath {
  VehicleId vehicle;
  geometry::Vec2 place_map_m = geometry::Vec2::Zero();

  bool operator==(const NoPath&) const = default;
};

/// State of a FrontierBook.
struct FrontierMemory {
  std::vector<NamedFrontier> named;
  std::uint32_t last_id = 0;  ///< the highest ever given
  std::vector<NoPath> no_path = {};

  bool operator==(const FrontierMemory&) const = default;
};

}  // namespace rali::map
