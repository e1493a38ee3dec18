#pragma once

#include <string>
#include <vector>

#include "sample.hpp"

namespace rali::degeneracy_bench {

/// Each detector for each number of rings, with one set of thresholds; other vehicles masked.
[[nodiscard]] std::string detector_table(const std::vector<Sample>& samples);

/// `aware` for each world, all rings.
[[nodiscard]] std::string place_table(const std::vector<Sample>& samples);

/// All figures of all scans.
[[nodiscard]] std::string json_of(const std::vector<Sample>& samples);

}  // namespace rali::degeneracy_bench
