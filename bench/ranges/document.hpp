#pragma once

#include <string>
#include <vector>

#include "rali/base/result.hpp"

namespace rali::ranges_bench {

/// The command that makes these tables again, without the options that do not change figures.
[[nodiscard]] std::string command_of(const std::vector<std::string>& words);

/// Puts `text` between the lines `<!-- ranges NAME -->` and `<!-- end -->` of a Markdown file.
/// `into`: FILE:NAME. Errors (kInput): no such file, or not these lines in it.
[[nodiscard]] Status write_into(const std::string& into, const std::string& text);

}  // namespace rali::ranges_bench
