#pragma once

#include "rali/cli/command.hpp"

namespace rali::cli {

/// `rali demo`: simulate, map, compare with the ground truth, draw.
[[nodiscard]] std::unique_ptr<Command> make_demo_command();

}  // namespace rali::cli
