#pragma once

#include <string>

#include "arguments.hpp"
#include "run.hpp"

namespace rali::accuracy {

/// The command that makes these runs again, without the options that do not change figures.
[[nodiscard]] std::string command_of(const std::vector<std::string>& words);

/// One row per scene and preset, the columns a reader asks for first: median / worst over seeds.
[[nodiscard]] std::string short_table(const std::vector<Scores>& runs);

/// Puts `text` between the lines `<!-- accuracy NAME -->` and `<!-- end -->` of a Markdown file.
/// Errors (kInput): no such file, or not these lines in it.
[[nodiscard]] Status write_into(const std::string& path, const std::string& name,
                                const std::string& text);

}  // namespace rali::accuracy
