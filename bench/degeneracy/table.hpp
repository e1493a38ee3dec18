#pragma once

#include <string>
#include <vector>

#include "sample.hpp"

namespace rali::degeneracy_bench {

/// Each detector for each number of rings, one set of thresholds; other vehicles masked.
[[nodiscard]] std::string detector_table(const std::vector<Sample>& samples);

/// `aware` place by place, all rings.
[[nodiscard]] std::string place_table(const std::vector<Sample>& samples);

/// Every figure of every scan.
[[nodiscard]] std::string json_of(const std::vector<Sample>& samples);

}  // namespace rali::degeneracy_bench
