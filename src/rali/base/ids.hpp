#pragma once

#include <compare>
#include <cstdint>

namespace rali {

/// Number of a vehicle within its fleet; the settings contain its name.
struct VehicleId {
  std::uint16_t value = 0;
  constexpr auto operator<=>(const VehicleId&) const = default;
};

/// A keyframe: its vehicle and its running number there, from 0.
struct KeyframeId {
  VehicleId vehicle;
  std::uint32_t seq = 0;
  constexpr auto operator<=>(const KeyframeId&) const = default;
};

}  // namespace rali
