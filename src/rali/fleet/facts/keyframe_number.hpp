#pragma once

#include <cstdint>

namespace rali::fleet {

/// Keyframe numbers are unique over all epochs of a vehicle, so that a KeyframeId names one
/// keyframe permanently: epoch e begins at e * 2^20. At one keyframe a second this suffices for
/// twelve days per start of the odometry, and for 4096 starts.
inline constexpr std::uint32_t kKeyframesPerEpoch = 1U << 20;
inline constexpr std::uint32_t kEpochsMax = 1U << 12;

[[nodiscard]] constexpr std::uint32_t first_keyframe_of(std::uint32_t epoch) {
  return epoch * kKeyframesPerEpoch;
}

[[nodiscard]] constexpr std::uint32_t epoch_of_keyframe(std::uint32_t keyframe) {
  return keyframe / kKeyframesPerEpoch;
}

}  // namespace rali::fleet
