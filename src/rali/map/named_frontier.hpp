#pragma once

#include <cstdint>
#include <vector>

#include "rali/base/ids.hpp"
#include "rali/geometry/types.hpp"

namespace rali::map {

/// What is remembered of a frontier from look to look, and from anchor to anchor.
struct NamedFrontier {
  std::uint32_t id = 0;  ///< from 1; stays while the frontier does
  geometry::Vec2 centre_map_m = geometry::Vec2::Zero();
  double size = 0.0;         ///< by FrontierSettings::size
  std::uint32_t visits = 0;  ///< that changed nothing

  bool operator==(const NamedFrontier&) const = default;
};

/// A place to which a vehicle was sent and found no path.
struct NoPath {
  VehicleId vehicle;
  geometry::Vec2 place_map_m = geometry::Vec2::Zero();

  bool operator==(const NoPath&) const = default;
};

/// What a FrontierBook knows.
struct FrontierMemory {
  std::vector<NamedFrontier> named;
  std::uint32_t last_id = 0;  ///< the highest that was ever given
  std::vector<NoPath> no_path = {};

  bool operator==(const FrontierMemory&) const = default;
};

}  // namespace rali::map
