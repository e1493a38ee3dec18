#pragma once

#include <functional>
#include <string>
#include <vector>

#include "rali/cli/command.hpp"

namespace rali::cli {

/// The whole program: parses, runs one command, prints its error, returns the exit code. Throws
/// nothing: an escaped exception is an internal error (5), out of memory is 4.
/// @param arguments without the program's name.
[[nodiscard]] int run_app(const std::vector<std::string>& arguments, Session& session);

/// Runs `body` and maps its exceptions to exit codes; outermost error handler of the program.
[[nodiscard]] int run_guarded(const std::function<int()>& body, Session& session);

}  // namespace rali::cli
