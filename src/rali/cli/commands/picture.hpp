#pragma once

#include "rali/cli/command.hpp"

namespace rali::cli {

/// `rali picture DIR`: maps from above for a paper.
[[nodiscard]] std::unique_ptr<Command> make_picture_command();

}  // namespace rali::cli
