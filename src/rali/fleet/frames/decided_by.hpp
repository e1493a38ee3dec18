#pragma once

#include <cstdint>
#include <string_view>

#include "rali/base/settings.hpp"

namespace rali::fleet {

/// The measurements that determine a frame.
enum class DecidedBy : std::uint8_t { kRanges, kScans, kRangesAndScans, kPrior };

/// As shown to the user.
inline constexpr ChoiceNames<4> kDecidedByNames = {"ranges", "scans", "ranges and scans",
                                                   "the prior"};

[[nodiscard]] constexpr std::string_view decided_by_text(DecidedBy by) {
  return kDecidedByNames[static_cast<std::size_t>(by)];
}

}  // namespace rali::fleet
