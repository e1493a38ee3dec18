#pragma once

#include <chrono>
#include <map>
#include <string>

#include "rali/cli/session.hpp"
#include "rali/drive/map_run.hpp"

namespace rali::cli {

/// Shows a run on stderr: a live line on a terminal, one line per 10 % elsewhere, or one JSON
/// object per line.
class ProgressView final : public drive::ProgressSink {
 public:
  explicit ProgressView(Session& session);

  void progress(const drive::Progress& progress) override;
  void finding(const Finding& finding) override;

 private:
  Session& session_;
  std::chrono::steady_clock::time_point begin_;
  std::map<std::string, int> tenths_;  ///< last line per vehicle and stage
  std::map<std::string, int> warned_;  ///< warnings per vehicle and kind
  std::string shown_;                  ///< the vehicle in the live line, and since when
  std::chrono::steady_clock::time_point shown_since_;
};

/// "v1 [#########-----]  62 %  6.4x  312 m  degenerate  8 %  ETA 0:41"; without the bar if `bar` is
/// false.
/// @param eta_s below 0: unknown.
[[nodiscard]] std::string progress_line(const drive::Progress& progress, bool bar, double eta_s);

/// "v1 /imu at 12.3 s: text. Remedy": a finding as one line.
[[nodiscard]] std::string finding_line(const Finding& finding);

}  // namespace rali::cli
