#pragma once

#include <functional>
#include <string>
#include <vector>

#include "rali/cli/command.hpp"

namespace rali::cli {

/// The whole program: parses, runs one command, prints its error, gives the exit code. Nothing is
/// thrown out of it: what escapes a room is an internal fault (5), no memory is 4.
/// @param arguments without the program's name.
[[nodiscard]] int run_app(const std::vector<std::string>& arguments, Session& session);

/// Runs `body` and makes an exit code of what it throws: the outermost edge of the program.
[[nodiscard]] int run_guarded(const std::function<int()>& body, Session& session);

}  // namespace rali::cli
