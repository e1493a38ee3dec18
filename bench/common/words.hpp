#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "rali/base/result.hpp"

namespace rali::bench {

/// "a,b" as its parts; empty ones are left out.
[[nodiscard]] std::vector<std::string> split(const std::string& text);

/// "1,2,5-8" as numbers, at most 1000. Errors (kUsage): a part that is no whole number, none at
/// all.
[[nodiscard]] Result<std::vector<std::uint64_t>> parse_seeds(const std::string& text);

}  // namespace rali::bench
