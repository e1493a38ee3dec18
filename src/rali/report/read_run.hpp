#pragma once

#include <string>

#include "rali/base/result.hpp"
#include "rali/report/run_data.hpp"

namespace rali::report {

/// Reads an output folder of `rali map`. Absent parts are left empty; damaged
/// parts are named in RunData::unreadable.
/// Errors: kInput if it is no folder, or holds no output of rali map.
[[nodiscard]] Result<RunData> read_run(const std::string& out_dir);

}  // namespace rali::report
