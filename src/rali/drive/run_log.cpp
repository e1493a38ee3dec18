#include "rali/drive/run_log.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sys/resource.h>

#include "rali/drive/output/metrics.hpp"
#include "rali/drive/output/out_dir.hpp"
#include "rali/io/files/atomic_file.hpp"

namespace rali::drive {

std::string finding_line(const Finding& finding) {
  const char* severity = finding.severity == Severity::kError     ? "error"
                         : finding.severity == Severity::kWarning ? "warning"
                                                                  : "info";
  std::string line = fmt::format("{} {}", severity, finding.id);
  if (!finding.vehicle.empty()) line += fmt::format(" [{}]", finding.vehicle);
  line += ": " + finding.text;
  for (const std::string* part : {&finding.effect, &finding.remedy}) {
    if (!part->empty()) line += (line.ends_with('.') ? " " : ". ") + *part;
  }
  return line;
}

double RunLog::seconds_since(std::chrono::steady_clock::time_point t) const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - t).count();
}

void RunLog::line(std::string_view text) {
  fmt::format_to(std::back_inserter(text_), "{:9.3f} {}\n", seconds_since(begin_), text);
}

void RunLog::finding(const Finding& f) { line(finding_line(f)); }

void RunLog::stage(std::string name) {
  stages_s_.emplace_back(std::move(name), seconds_since(stage_start_));
  stage_start_ = std::chrono::steady_clock::now();
}

Status RunLog::write(const std::string& out_dir, double data_s) const {
  if (Status s = io::write_file_atomic(out_dir + "/run.log", text_); !s) return s;
  nlohmann::ordered_json json;
  json["schema"] = 1;
  const double total_s = seconds_since(begin_);
  json["total_s"] = total_s;
  json["data_s"] = data_s;
  json["speed"] = total_s > 0.0 ? data_s / total_s : 0.0;
  rusage usage{};
  if (getrusage(RUSAGE_SELF, &usage) == 0) json["memory_max_mb"] = usage.ru_maxrss / 1024;
  json["stages_s"] = nlohmann::ordered_json::object();
  for (const auto& [name, seconds] : stages_s_) json["stages_s"][name] = seconds;
  return io::write_file_atomic(out_dir + "/timing.json", json.dump(1) + '\n');
}

void mark_failed(const std::string& out_dir, std::string_view why) noexcept {
  try {
    std::error_code error;
    if (!std::filesystem::exists(out_dir + "/status.json", error)) return;
    const std::string status(status_name(RunStatus::kFailed));
    {
      std::ofstream log(out_dir + "/run.log", std::ios::app);
      // Behind the column of the seconds: the start time of the run is not known here.
      log << fmt::format("{:9} {}\n{:9} {}\n", "", why, "", status);
    }
    static_cast<void>(write_status(out_dir, status, true));
  } catch (...) {
    return;
  }
}

}  // namespace rali::drive
