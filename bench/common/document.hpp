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

/// Puts `text` between the lines `<!-- PROGRAM NAME -->` and `<!-- end -->` of a Markdown file.
/// Errors (kInput): no such file, or not these lines in it.
[[nodiscard]] Status write_into(const std::string& path, const std::string& program,
                                const std::string& name, const std::string& text);

/// The whole file, anew. Errors (kInput): it cannot be written.
[[nodiscard]] Status write_file(const std::string& path, const std::string& text);

}  // namespace rali::bench
