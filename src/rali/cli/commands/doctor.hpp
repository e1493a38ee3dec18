#pragma once

#include "rali/cli/command.hpp"

namespace rali::cli {

/// `rali doctor INPUT...`: checks a recording, reports problems and remedies.
[[nodiscard]] std::unique_ptr<Command> make_doctor_command();

}  // namespace rali::cli
