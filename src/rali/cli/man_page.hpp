#pragma once

#include <string>

#include "rali/cli/command.hpp"

namespace rali::cli {

/// rali(1) in man(7) macros, made from the same tables as `--help`.
[[nodiscard]] std::string man_page(const CommandList& commands);

}  // namespace rali::cli
