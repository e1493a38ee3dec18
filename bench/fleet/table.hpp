#pragma once

#include <string>
#include <vector>

#include "score.hpp"

namespace rali::fleet_bench {

/// Median / worst over the seeds per scene and row, traffic by kind of message, and the reasons of
/// vehicles that were not joined; Markdown.
[[nodiscard]] std::string tables_of(const std::vector<Scores>& runs);

/// One row per run.
[[nodiscard]] std::string run_table(const std::vector<Scores>& runs);

/// One line about a run, as progress output.
[[nodiscard]] std::string line_of(const Scores& run);

}  // namespace rali::fleet_bench
