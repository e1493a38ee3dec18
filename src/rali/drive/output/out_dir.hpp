#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "rali/base/result.hpp"

namespace rali::drive {

/// True for a path (relative to the output folder, '/' between) that only rali writes there,
/// temporary names included.
[[nodiscard]] bool is_output_name(std::string_view relative);

/// True for outputs that may differ between two equal runs: run.log, timing.json, status.json,
/// report.html.
[[nodiscard]] bool is_exempt_name(std::string_view relative);

/// Prepares the output folder. A folder that is not empty is refused, unless `overwrite`: then the
/// files that rali writes are removed, and only if status.json states that rali made them. Other
/// files are never touched. Errors: kUsage, kMachine.
[[nodiscard]] Status prepare_out_dir(const std::string& path, bool overwrite);

/// All outputs in the folder, relative, sorted by name.
[[nodiscard]] Result<std::vector<std::string>> list_outputs(const std::string& path);

/// status.json: `status` is running, complete, partial, interrupted or failed; with `hashes` the
/// SHA-256 of every output but the exempt ones. Errors: kMachine.
[[nodiscard]] Status write_status(const std::string& path, std::string_view status, bool hashes);

/// Adds one more output, written after the end of the run, to the hashes of status.json. The text
/// between `exempt_start` and `exempt_end` may differ between equal runs and is left out of the
/// hash. In a folder without status.json it does nothing. Errors: kInput, kMachine.
[[nodiscard]] Status add_to_status(const std::string& path, const std::string& name,
                                   std::string_view exempt_start, std::string_view exempt_end);

}  // namespace rali::drive
