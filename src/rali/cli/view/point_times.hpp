#pragma once

#include <string>
#include <vector>

#include "rali/report/run_data.hpp"

namespace rali::cli {

/// First observation time of each point of run.map [s since run.begin]: the stamp of the earliest
/// keyframe that has a point within about 0.3 m. NaN if no keyframe has one; empty if the folder
/// holds no keyframes (they are optional). Unreadable files are skipped.
[[nodiscard]] std::vector<float> first_seen_s(const std::string& out_dir,
                                              const report::RunData& run);

}  // namespace rali::cli
