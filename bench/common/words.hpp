#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "rali/base/result.hpp"

namespace rali::bench {

/// The parts of "a,b"; empty ones are left out.
[[nodiscard]] std::vector<std::string> split(const std::string& text);

/// The numbers in "1,2,5-8", at most 1000. Errors (kUsage): a part that is not a whole number, no
/// number at all.
[[nodiscard]] Result<std::vector<std::uint64_t>> parse_seeds(const std::string& text);

}  // namespace rali::bench
