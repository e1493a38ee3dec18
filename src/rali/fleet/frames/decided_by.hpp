#pragma once

#include <cstdint>
#include <string_view>

namespace rali::fleet {

/// The measurements that determine a frame.
enum class DecidedBy : std::uint8_t { kRanges, kScans, kRangesAndScans, kPrior };

/// As shown to the user: "ranges and scans".
[[nodiscard]] constexpr std::string_view decided_by_text(DecidedBy by) {
  switch (by) {
    case DecidedBy::kRanges:
      return "ranges";
    case DecidedBy::kScans:
      return "scans";
    case DecidedBy::kRangesAndScans:
      return "ranges and scans";
    case DecidedBy::kPrior:
      return "the prior";
  }
  return "";
}

}  // namespace rali::fleet
