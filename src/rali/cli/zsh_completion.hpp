#pragma once

#include <string>

#include "rali/cli/command.hpp"

namespace rali::cli {

/// The completion script of zsh: a file `_rali` of $fpath, or to be sourced. Each option comes with
/// its description.
[[nodiscard]] std::string zsh_completion(const CommandList& commands);

}  // namespace rali::cli
