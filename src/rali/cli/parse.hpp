#pragma once

#include <string>
#include <vector>

#include "rali/cli/command.hpp"

namespace rali::cli {

/// The command's own options and the common ones.
[[nodiscard]] std::vector<Option> all_options(Command& command, CommonOptions& common);

/// The request in the words after the command's name.
enum class Parsed { kRun, kHelp, kHelpAll };

/// Fills the targets of a command's options from its words.
/// Errors (kUsage, where = "rali NAME"): unknown option with the nearest name, missing or wrong
/// value, too few inputs.
[[nodiscard]] Result<Parsed> parse_words(Command& command, CommonOptions& common,
                                         const std::vector<std::string>& words);

}  // namespace rali::cli
