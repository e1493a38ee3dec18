#pragma once

#include "rali/cli/command.hpp"

namespace rali::cli {

/// Every command of the program, in the order of the help. Unfinished commands are not listed.
[[nodiscard]] CommandList all_commands();

[[nodiscard]] std::unique_ptr<Command> make_map_command();
[[nodiscard]] std::unique_ptr<Command> make_completion_command();
/// Hidden: print docs/reference/settings.md and docs/reference/cli.md.
[[nodiscard]] std::unique_ptr<Command> make_help_settings_command();
[[nodiscard]] std::unique_ptr<Command> make_help_cli_command();
[[nodiscard]] std::unique_ptr<Command> make_help_man_command();

}  // namespace rali::cli
