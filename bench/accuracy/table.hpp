#pragma once

#include "run.hpp"

namespace rali::accuracy {

/// One row per run.
[[nodiscard]] std::string run_table(const std::vector<Scores>& runs);

/// One row per scene and preset: median / worst over the seeds.
[[nodiscard]] std::string summary_table(const std::vector<Scores>& runs);

/// The same with the columns of these titles only.
[[nodiscard]] std::string table_of(const std::vector<Scores>& runs,
                                   const std::vector<std::string>& titles);

}  // namespace rali::accuracy
