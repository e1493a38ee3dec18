#pragma once

#include <memory>

#include "rali/cli/command.hpp"

namespace rali::cli {

/// `rali run`: one vehicle of a fleet, live.
[[nodiscard]] std::unique_ptr<Command> make_run_command();

}  // namespace rali::cli
