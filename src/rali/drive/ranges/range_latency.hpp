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

/// Estimate from one vehicle's motion alone, without the prior of its filter, which keeps the
/// offset near zero. Empty where the motion gave no information: a vehicle at standstill, or moving
/// in one direction.
/// @param prior_sigma_s of the filter's offset
[[nodiscard]] std::optional<RangeLatency> latency_by_motion(
    const std::optional<vehicle::RangeStampOffset>& offset, double prior_sigma_s);

/// Combines several vehicles that used ranges of one source. Each range has corrected one vehicle
/// only, so the estimates are independent.
[[nodiscard]] std::optional<RangeLatency> combined(
    std::span<const std::optional<RangeLatency>> vehicles);

/// "46 ms, sigma 5 ms".
[[nodiscard]] std::string latency_words(const RangeLatency& latency);

}  // namespace rali::drive
