#pragma once

#include "rali/cli/command.hpp"

namespace rali::cli {

/// `rali evaluate`: results against truth.
[[nodiscard]] std::unique_ptr<Command> make_evaluate_command();

}  // namespace rali::cli
