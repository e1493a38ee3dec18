#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace rali::io {

/// Columns and JSON keys of our own files that had another name until version 0.1. Readers take
/// both names in this release.

/// The name in version 0.1 of what is called `name` today; empty where it had the same.
[[nodiscard]] std::string_view old_name_of(std::string_view name);

/// Today's name of what version 0.1 called `name`; `name` itself where it is the same.
[[nodiscard]] std::string_view current_name_of(std::string_view name);

/// One sentence for each kind of file in the output folder `out_dir` that has names of version 0.1.
/// Files that are absent or damaged have none: whoever reads them reports that.
[[nodiscard]] std::vector<std::string> notices_of_old_names(const std::string& out_dir);

}  // namespace rali::io
