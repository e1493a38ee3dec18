#pragma once

#include <string>
#include <vector>

#include "rali/base/result.hpp"

namespace rali::blindness {

/// The command that makes these runs again, without the options that do not change figures.
[[nodiscard]] std::string command_of(const std::vector<std::string>& words);

/// Puts `text` between the lines `<!-- degeneracy NAME -->` and `<!-- end -->` of a Markdown file.
/// @param target FILE:NAME. Errors (kInput): no such file, or not these lines in it.
[[nodiscard]] Status write_into(const std::string& target, const std::string& text);

[[nodiscard]] Status write_file(const std::string& path, const std::string& text);

}  // namespace rali::blindness
