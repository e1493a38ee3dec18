#pragma once

#include "rali/cli/command.hpp"

namespace rali::cli {

/// `rali report`: builds report.html of a run again, or sets runs side by side.
[[nodiscard]] std::unique_ptr<Command> make_report_command();

}  // namespace rali::cli
