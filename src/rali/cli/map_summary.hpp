#pragma once

#include <string>
#include <vector>

#include "rali/drive/map_run.hpp"

namespace rali::cli {

/// The text that `rali map` prints to stdout when it is done.
/// @param page  what to open first: the report, or the folder if there is none
[[nodiscard]] std::string summary_text(const drive::MapSummary& summary, const std::string& page);

/// "lidar of v1: 0.08 m forward ... (settings)" and the other decisions about one input.
[[nodiscard]] std::string input_text(const drive::InputReport& report);

/// One condition of --require.
struct Requirement {
  std::string name;  ///< connected, max_sigma_m
  double limit = 0.0;
};

/// Errors (kUsage): an unknown name, a value that is no number.
[[nodiscard]] Result<std::vector<Requirement>> parse_requirements(
    const std::vector<std::string>& texts);

/// One sentence for each violated condition.
[[nodiscard]] std::vector<std::string> broken_requirements(
    const std::vector<Requirement>& requirements, const drive::MapSummary& summary);

/// The exit code of a finished run (before --require).
[[nodiscard]] int exit_code_of(const drive::MapSummary& summary, int signal_number);

}  // namespace rali::cli
