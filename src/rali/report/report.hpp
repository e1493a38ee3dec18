#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/report/run_data.hpp"

namespace rali::report {

/// Content that differs between equal runs is placed between these; status.json hashes the rest.
inline constexpr std::string_view kSpeedStart = "<!--speed-->", kSpeedEnd = "<!--/speed-->";

/// The self-contained HTML page of one run, under 10 MB. The same data give the same bytes.
[[nodiscard]] std::string report_html(const RunData& run);

/// Several runs compared: numbers, trajectories, settings that differ.
[[nodiscard]] std::string comparison_html(const std::vector<RunData>& runs);

/// Reads `out_dir` and writes the page to `path`. Errors: kInput, kMachine.
[[nodiscard]] Status write_report(const std::string& out_dir, const std::string& path);

/// Reads each folder and writes one page. Errors: kInput, kMachine.
[[nodiscard]] Status write_comparison(const std::vector<std::string>& out_dirs,
                                      const std::string& path);

}  // namespace rali::report
