#pragma once

#include "rali/cli/command.hpp"

namespace rali::cli {

[[nodiscard]] std::unique_ptr<Command> make_view_command();
[[nodiscard]] std::unique_ptr<Command> make_status_command();
[[nodiscard]] std::unique_ptr<Command> make_operator_command();

}  // namespace rali::cli
