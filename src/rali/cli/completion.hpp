#pragma once

#include <string>

#include "rali/cli/command.hpp"

namespace rali::cli {

/// The completion script of a shell (bash, zsh, fish); empty for another one. Options that take one
/// of a few words complete these words, too.
[[nodiscard]] std::string completion_script(const std::string& shell, const CommandList& commands);

}  // namespace rali::cli
