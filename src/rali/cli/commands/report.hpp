#pragma once

#include <string>
#include <vector>

#include "rali/cli/command.hpp"

namespace rali::cli {

/// `rali report`: rebuilds report.html of a run, or compares runs.
[[nodiscard]] std::unique_ptr<Command> make_report_command();

/// One warning for each kind of file in these output folders that has names of an older version.
void warn_of_old_names(const std::vector<std::string>& folders, Session& session);

}  // namespace rali::cli
