#pragma once

#include <string>

#include "rali/base/result.hpp"
#include "rali/report/run_data.hpp"

namespace rali::report {

/// Reads an output folder of `rali map`. Parts that are absent are left empty; parts that are
/// damaged are named in RunData::unreadable.
/// Errors: kInput for what is no folder, or holds nothing that rali map writes.
[[nodiscard]] Result<RunData> read_run(const std::string& out_dir);

}  // namespace rali::report
