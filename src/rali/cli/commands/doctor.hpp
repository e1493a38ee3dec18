#pragma once

#include "rali/cli/command.hpp"

namespace rali::cli {

/// `rali doctor INPUT...`: is this recording fit, what is wrong, what to do.
[[nodiscard]] std::unique_ptr<Command> make_doctor_command();

}  // namespace rali::cli
