#pragma once

#include <string>
#include <vector>

#include "rali/cli/command.hpp"

namespace rali::cli {

/// The command's own options and those that every command takes.
[[nodiscard]] std::vector<Option> all_options(Command& command, CommonOptions& common);

/// What the words after the command's name ask for.
enum class Parsed { kRun, kHelp, kHelpAll };

/// Fills the targets of a command's options from its words.
/// Errors (kUsage, where = "rali NAME"): unknown option with the nearest name, missing or wrong
/// value, too few inputs.
[[nodiscard]] Result<Parsed> parse_words(Command& command, CommonOptions& common,
                                         const std::vector<std::string>& words);

}  // namespace rali::cli
