#pragma once

#include "rali/cli/command.hpp"

namespace rali::cli {

/// `rali info FILE`: lists the content of a file.
[[nodiscard]] std::unique_ptr<Command> make_info_command();

}  // namespace rali::cli
