#pragma once

#include <string>
#include <vector>

#include "score.hpp"

namespace rali::tunnel {

/// Tables of a suite in Markdown: median / worst over the seeds per row; for NEES the mean over
/// runs and the 95 % interval of that mean.
[[nodiscard]] std::string tables_of(const std::string& suite, const std::vector<Scores>& runs);

/// All figures of all runs.
[[nodiscard]] std::string json_of(const std::vector<Scores>& runs);

/// One line about a run, as progress output.
[[nodiscard]] std::string line_of(const Scores& run);

}  // namespace rali::tunnel
