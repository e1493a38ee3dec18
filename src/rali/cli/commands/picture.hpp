#pragma once

#include "rali/cli/command.hpp"

namespace rali::cli {

/// `rali picture DIR`: the map of a run from above, as a PNG.
[[nodiscard]] std::unique_ptr<Command> make_picture_command();

}  // namespace rali::cli
