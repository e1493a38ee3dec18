#pragma once

#include "rali/cli/command.hpp"

namespace rali::cli {

/// `rali info FILE`: what is in this file.
[[nodiscard]] std::unique_ptr<Command> make_info_command();

}  // namespace rali::cli
