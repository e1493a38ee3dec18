#pragma once

#include <optional>
#include <span>
#include <string>

#include "rali/drive/ranges/range_options.hpp"
#include "rali/vehicle/vehicle.hpp"

namespace rali::drive {

/// Age of ranges at their stamps.
struct RangeLatency {
  double value_s = 0.0;
  std::optional<double> sigma_s;  ///< empty: given, not estimated
};

/// What one vehicle's motion alone says, without the prior of its filter, which holds the offset
/// near zero. Empty where the motion has said nothing: a vehicle that stands, or drives one way.
/// @param prior_sigma_s of the filter's offset
[[nodiscard]] std::optional<RangeLatency> latency_by_motion(
    const std::optional<vehicle::RangeStampOffset>& offset, double prior_sigma_s);

/// Of several vehicles that used ranges of one source. Each range has moved one vehicle only, so
/// that what they say is independent.
[[nodiscard]] std::optional<RangeLatency> combined(
    std::span<const std::optional<RangeLatency>> vehicles);

/// "46 ms, sigma 5 ms".
[[nodiscard]] std::string latency_words(const RangeLatency& latency);

}  // namespace rali::drive
