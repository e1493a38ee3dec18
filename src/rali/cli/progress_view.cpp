#include "rali/cli/progress_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "rali/report/findings_shown.hpp"

namespace rali::cli {
namespace {

constexpr int kBarWidth = 14;

std::string bar_text(double fraction) {
  const int filled = static_cast<int>(std::lround(fraction * kBarWidth));
  return '[' + std::string(static_cast<std::size_t>(filled), '#') +
         std::string(static_cast<std::size_t>(kBarWidth - filled), '-') + "] ";
}

/// Text of a recording may be invalid UTF-8, which must not stop a run.
std::string json_line(const nlohmann::ordered_json& object) {
  return object.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

std::string progress_json(const drive::Progress& progress) {
  return json_line({{"vehicle", progress.vehicle},
                    {"stage", progress.stage},
                    {"fraction", progress.fraction},
                    {"speed", progress.speed},
                    {"path_m", progress.path_m},
                    {"degenerate_fraction", progress.degenerate_fraction},
                    {"ranges", progress.ranges},
                    {"ranges_used", progress.ranges_used},
                    {"t_s", progress.t.s()}});
}

std::string finding_json(const Finding& finding) {
  constexpr std::array<const char*, 3> kNames{"info", "warning", "error"};
  return json_line({{"id", finding.id},
                    {"severity", kNames.at(static_cast<std::size_t>(finding.severity))},
                    {"vehicle", finding.vehicle},
                    {"topic", finding.topic},
                    {"t_s", finding.t.s()},
                    {"text", finding.text},
                    {"effect", finding.effect},
                    {"remedy", finding.remedy}});
}

void add_sentence(std::string& line, const std::string& sentence) {
  if (sentence.empty()) return;
  if (!line.empty() && line.back() != '.' && line.back() != ':') line += '.';
  const bool begins = line.empty() || line.back() == '.';
  if (!line.empty()) line += ' ';
  const std::size_t at = line.size();
  line += sentence;
  // A word with punctuation (deskewed:, imu.topic) is a key and keeps its case.
  const std::string word = sentence.substr(0, sentence.find(' '));
  const bool plain = word.find_first_not_of("abcdefghijklmnopqrstuvwxyz,") == std::string::npos;
  if (begins && at > 0 && plain) line[at] = static_cast<char>(line[at] - 'a' + 'A');
}

}  // namespace

ProgressView::ProgressView(Session& session)
    : session_(session), begin_(std::chrono::steady_clock::now()) {}

void ProgressView::progress(const drive::Progress& progress) {
  const std::string& kind = session_.options.progress;
  if (kind == "off" || (session_.options.quiet && kind != "json")) return;
  const double fraction =
      std::isfinite(progress.fraction) ? std::clamp(progress.fraction, 0.0, 1.0) : 0.0;
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin_;
  const double eta_s = fraction > 0.01 ? elapsed.count() * (1.0 - fraction) / fraction : -1.0;
  if (session_.live() && kind == "auto") {
    // Vehicles run in parallel: each is shown on the line for one second, to stay readable.
    const auto now = std::chrono::steady_clock::now();
    if (progress.vehicle != shown_) {
      if (now - shown_since_ < std::chrono::seconds(1) && fraction < 1.0) return;
      shown_ = progress.vehicle;
      shown_since_ = now;
    }
    session_.live_line(progress_line(progress, true, eta_s));
    return;
  }
  const int tenth = static_cast<int>(fraction * 10.0);
  const auto [last, is_new] = tenths_.emplace(progress.vehicle + '/' + progress.stage, tenth);
  if (!is_new && last->second >= tenth) return;
  if (is_new && tenth == 0) return;  // the start is not reported
  last->second = tenth;
  session_.progress_text(kind == "json" ? progress_json(progress)
                                        : progress_line(progress, false, eta_s));
}

void ProgressView::finding(const Finding& finding) {
  if (session_.options.progress == "json") {
    session_.progress_text(finding_json(finding));
    return;
  }
  if (finding.severity == Severity::kInfo) return session_.detail(finding_line(finding));
  const int count = ++warned_[finding.vehicle + '/' + finding.id];
  if (count <= report::kFindingsShownMax) return session_.warning(finding_line(finding));
  if (count == report::kFindingsShownMax + 1) {
    session_.warning(fmt::format("{}{}more of {}: see metrics.json.", finding.vehicle,
                                 finding.vehicle.empty() ? "" : ": ", finding.id));
  }
  session_.detail(finding_line(finding));
}

std::string progress_line(const drive::Progress& progress, bool bar, double eta_s) {
  const double fraction =
      std::isfinite(progress.fraction) ? std::clamp(progress.fraction, 0.0, 1.0) : 0.0;
  std::string line = fmt::format("{} {}{:3.0f} %", progress.vehicle, bar ? bar_text(fraction) : "",
                                 100.0 * fraction);
  if (progress.stage != "odometry") {
    line += "  " + progress.stage;
  } else {
    line += fmt::format("  {:.1f}x  {:.0f} m  degenerate {:2.0f} %", progress.speed,
                        progress.path_m, 100.0 * progress.degenerate_fraction);
    if (progress.ranges > 0) {
      line += fmt::format("  ranges {}/{}", progress.ranges_used, progress.ranges);
    }
  }
  if (eta_s >= 0.0 && fraction < 1.0) {
    const long seconds = std::lround(std::min(eta_s, 359999.0));
    line += seconds < 3600 ? fmt::format("  ETA {}:{:02}", seconds / 60, seconds % 60)
                           : fmt::format("  ETA {}:{:02}:{:02}", seconds / 3600, seconds / 60 % 60,
                                         seconds % 60);
  }
  return line;
}

std::string finding_line(const Finding& finding) {
  std::string line = finding.vehicle;
  // The topic of a folder is the vehicle's name, which is not repeated.
  if (!finding.topic.empty() && finding.topic != finding.vehicle)
    line += (line.empty() ? "" : " ") + finding.topic;
  if (!line.empty()) line += ':';
  add_sentence(line, finding.text);
  add_sentence(line, finding.effect);
  add_sentence(line, finding.remedy);
  if (!line.empty() && line.back() != '.') line += '.';
  return line;
}

}  // namespace rali::cli
