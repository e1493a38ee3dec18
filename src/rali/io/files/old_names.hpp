#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace rali::io {

/// Columns and JSON keys of this program's files that had another name up to version 0.1. Readers
/// accept both names in this release.

/// The version 0.1 name of what is called `name` now; empty if unchanged.
[[nodiscard]] std::string_view old_name_of(std::string_view name);

/// The current name of what version 0.1 called `name`; `name` itself if unchanged.
[[nodiscard]] std::string_view current_name_of(std::string_view name);

/// One sentence for each kind of file in the output folder `out_dir` that has names of version 0.1.
/// Absent or damaged files have none: their readers report the damage.
[[nodiscard]] std::vector<std::string> notices_of_old_names(const std::string& out_dir);

}  // namespace rali::io
