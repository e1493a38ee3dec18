#pragma once

#include "rali/cli/command.hpp"

namespace rali::cli {

[[nodiscard]] std::unique_ptr<Command> make_convert_command();

}  // namespace rali::cli
