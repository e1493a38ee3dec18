#pragma once

#include "run.hpp"

namespace rali::accuracy {

/// One row per run.
[[nodiscard]] std::string run_table(const std::vector<Scores>& runs);

/// One row per scene and preset: median / worst over the seeds.
[[nodiscard]] std::string summary_table(const std::vector<Scores>& runs);

}  // namespace rali::accuracy
