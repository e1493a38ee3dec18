#pragma once

#include <string>
#include <vector>

#include "rali/base/result.hpp"

namespace rali::bench {

/// The command that reproduces these figures, without the options that do not change them
/// (`silent`, each with one value).
[[nodiscard]] std::string command_of(const std::string& program,
                                     const std::vector<std::string>& words,
                                     const std::vector<std::string>& silent);

/// Writes a command and the tables that it produces between the lines `<!-- PROGRAM NAME -->` and
/// `<!-- end -->` of a Markdown file.
/// @param into FILE:NAME. Errors (kUsage): it does not have that form; (kInput): no such file, or
/// it does not contain these lines.
[[nodiscard]] Status write_into(const std::string& into, const std::string& program,
                                const std::string& command, const std::string& tables);

/// Overwrites the whole file. Errors (kInput): it cannot be written.
[[nodiscard]] Status write_file(const std::string& path, const std::string& text);

}  // namespace rali::bench
