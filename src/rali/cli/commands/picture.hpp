#pragma once

#include "rali/cli/command.hpp"

namespace rali::cli {

/// `rali picture DIR`: top views of maps for a paper.
[[nodiscard]] std::unique_ptr<Command> make_picture_command();

}  // namespace rali::cli
