#pragma once

#include <string>

#include "rali/base/result.hpp"

namespace rali::jobs {

/// Writes report.html into the output folder of a run and lists it in status.json.
/// Errors: kInput, kMachine.
[[nodiscard]] Status add_report(const std::string& out_dir);

}  // namespace rali::jobs
