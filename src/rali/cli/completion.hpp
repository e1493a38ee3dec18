#pragma once

#include <string>

#include "rali/cli/command.hpp"

namespace rali::cli {

/// The completion script of a shell (bash, zsh, fish); empty for any other. Options with a fixed
/// set of words complete these words, too.
[[nodiscard]] std::string completion_script(const std::string& shell, const CommandList& commands);

}  // namespace rali::cli
