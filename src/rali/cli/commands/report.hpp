#pragma once

#include <string>
#include <vector>

#include "rali/cli/command.hpp"

namespace rali::cli {

/// `rali report`: builds report.html of a run again, or sets runs side by side.
[[nodiscard]] std::unique_ptr<Command> make_report_command();

/// One warning for each kind of file in these output folders that has names of an older version.
void warn_of_old_names(const std::vector<std::string>& folders, Session& session);

}  // namespace rali::cli
