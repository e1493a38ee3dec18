#pragma once

#include <string>
#include <vector>

#include "rali/base/result.hpp"

namespace rali::bench {

/// The command that makes these figures again, without the options that do not change them
/// (`silent`, each with one value).
[[nodiscard]] std::string command_of(const std::string& program,
                                     const std::vector<std::string>& words,
                                     const std::vector<std::string>& silent);

/// Puts a command and the tables that it makes between the lines `<!-- PROGRAM NAME -->` and
/// `<!-- end -->` of a Markdown file.
/// @param into FILE:NAME. Errors (kUsage): it is not of that form; (kInput): no such file, or not
///        these lines in it.
[[nodiscard]] Status write_into(const std::string& into, const std::string& program,
                                const std::string& command, const std::string& tables);

/// The whole file, anew. Errors (kInput): it cannot be written.
[[nodiscard]] Status write_file(const std::string& path, const std::string& text);

}  // namespace rali::bench
