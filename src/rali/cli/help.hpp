#pragma once

#include <string>

#include "rali/cli/command.hpp"

namespace rali::cli {

/// `rali -h`: the commands. At most 80 columns.
[[nodiscard]] std::string program_help(const CommandList& commands);

/// `rali CMD -h`: summary, two examples, options, exit codes; at most 40 lines of 80 columns.
/// With `all` the rare options too.
[[nodiscard]] std::string command_help(Command& command, bool all);

/// docs/reference/cli.md.
[[nodiscard]] std::string cli_manual(const CommandList& commands);

}  // namespace rali::cli
