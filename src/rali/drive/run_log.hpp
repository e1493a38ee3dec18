#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"

namespace rali::drive {

/// run.log and timing.json: the two outputs that may differ between equal runs.
class RunLog {
 public:
  RunLog() : begin_(std::chrono::steady_clock::now()), stage_start_(begin_) {}

  /// A line with the seconds since the start of the run.
  void line(std::string_view text);
  void finding(const Finding& finding);

  /// Ends the current stage and records how long it took.
  void stage(std::string name);

  /// Writes both into the folder. Errors: kMachine.
  [[nodiscard]] Status write(const std::string& out_dir, double data_s) const;

 private:
  [[nodiscard]] double seconds_since(std::chrono::steady_clock::time_point t) const;

  std::chrono::steady_clock::time_point begin_, stage_start_;
  std::string text_;
  std::vector<std::pair<std::string, double>> stages_s_;
};

/// For a run that has written its files: adds `why` to its run.log and sets status.json to failed.
/// A folder without status.json is not changed. Write errors are ignored: the caller has to report
/// the fault itself.
void mark_failed(const std::string& out_dir, std::string_view why) noexcept;

/// "warning D08 [v1]: the accelerometer ... remedy".
[[nodiscard]] std::string finding_line(const Finding& finding);

}  // namespace rali::drive
