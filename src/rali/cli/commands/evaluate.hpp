#pragma once

#include "rali/cli/command.hpp"

namespace rali::cli {

/// `rali evaluate`: compares results with ground truth.
[[nodiscard]] std::unique_ptr<Command> make_evaluate_command();

}  // namespace rali::cli
