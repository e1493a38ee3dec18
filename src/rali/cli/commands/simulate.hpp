#pragma once

#include <memory>

#include "rali/cli/command.hpp"

namespace rali::cli {

/// `rali simulate`: a fleet recording with exact ground truth.
[[nodiscard]] std::unique_ptr<Command> make_simulate_command();

}  // namespace rali::cli
