#pragma once

#include <filesystem>
#include <string>

#include "rali/base/result.hpp"

namespace rali::frames_bench {

/// The Monte Carlo table of algorithms_fleet 7.2.
[[nodiscard]] std::string geometry_table(int runs);

/// Random starts of two or three vehicles until all are initialised.
[[nodiscard]] std::string start_table(int starts);

/// Recorded fleets with unknown start frames.
[[nodiscard]] Result<std::string> recorded_table(const std::filesystem::path& folder);

}  // namespace rali::frames_bench
