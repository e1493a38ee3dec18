#pragma once

#include <string>
#include <vector>

#include "score.hpp"

namespace rali::fleet_bench {

/// Median / worst over the seeds per scene and row, traffic by kind of message, and what those that
/// were not joined wait for; Markdown.
[[nodiscard]] std::string tables_of(const std::vector<Scores>& runs);

/// One row per run.
[[nodiscard]] std::string run_table(const std::vector<Scores>& runs);

/// One line about a run, for who waits.
[[nodiscard]] std::string line_of(const Scores& run);

}  // namespace rali::fleet_bench
