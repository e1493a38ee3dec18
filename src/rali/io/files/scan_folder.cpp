#include "rali/io/files/scan_folder.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <system_error>
#include <utility>

#include <fmt/core.h>

#include "rali/base/counted.hpp"
#include "rali/io/files/content_kind.hpp"
#include "rali/io/files/input_file.hpp"
#include "rali/io/files/text.hpp"

namespace rali::io {
namespace {

namespace fs = std::filesystem;

constexpr Duration kAssumedPeriod = Duration::from_ns(100'000'000);
// An interrupted recorder may have written more times than clouds.
constexpr std::size_t kSurplusTimesMax = 5;
constexpr std::uint64_t kNamedMax = 20;
constexpr std::uint64_t kTimesBytesMax = std::uint64_t{1} << 30;

bool is_cloud_extension(const std::string& extension) {
  return extension == ".pcd" || extension == ".ply" || extension == ".bin";
}

}  // namespace

Result<std::vector<Time>> read_times_txt(const std::string& path) {
  const auto bytes = read_file(path, kTimesBytesMax);
  if (!bytes) return tl::make_unexpected(bytes.error());
  const std::string kind = content_kind(*bytes);
  if (kind != "text") return fail(ErrorCode::kInput, path, "is " + kind + ", not a list of times");
  std::vector<Time> times;
  std::string_view rest = as_text(*bytes);
  std::string_view line;
  for (std::uint64_t n = 1; take_line(rest, line); ++n) {
    line = trimmed(line);
    if (line.empty() || line.front() == '#') continue;
    const auto t = parse_stamp(line);
    const std::string where = fmt::format("{}:{}", path, n);
    if (!t) {
      return fail(ErrorCode::kInput, where, quoted(line) + " is no stamp in seconds",
                  "Each line holds one number, the time of one scan.");
    }
    if (!times.empty() && *t <= times.back()) {
      return fail(ErrorCode::kInput, where,
                  fmt::format("{} is not after the stamp before, {}", quoted(line),
                              format_stamp(times.back())));
    }
    times.push_back(*t);
  }
  return times;
}

Result<ScanFolder> ScanFolder::open(const std::string& path, const CloudFileOptions& options) {
  ScanFolder folder(path, options);
  if (auto status = folder.list(); !status) return tl::make_unexpected(status.error());
  if (folder.times_path_) {
    if (auto status = folder.read_times(); !status) return tl::make_unexpected(status.error());
  } else {
    folder.assume_times();
  }
  return folder;
}

Status ScanFolder::list() {
  std::error_code error;
  fs::directory_iterator at(path_, error);
  if (error) return fail(ErrorCode::kInput, path_, "is no folder that can be read");
  std::vector<std::string> names;
  std::map<std::string, std::size_t> kinds;
  for (; at != fs::directory_iterator(); at.increment(error)) {
    const std::string name = at->path().filename().string();
    std::error_code ignored;
    if (name.starts_with('.') || at->is_directory(ignored)) continue;
    if (name == "times.txt") times_path_ = at->path().string();
    if (name == "imu.csv") imu_path_ = at->path().string();
    if (name == "calib.yaml") calib_path_ = at->path().string();
    const std::string extension = lower_case(at->path().extension().string());
    if (!is_cloud_extension(extension)) continue;
    ++kinds[extension];
    names.push_back(name);
  }
  if (error) return fail(ErrorCode::kMachine, path_, "cannot be listed to its end");
  if (names.empty()) {
    return fail(ErrorCode::kInput, path_, "holds no scans (*.pcd, *.ply, *.bin)");
  }
  if (kinds.size() > 1) {
    std::string text;
    for (const auto& [kind, n] : kinds)
      text += fmt::format("{}{} {}", text.empty() ? "" : " and ", n, kind);
    return fail(ErrorCode::kInput, path_,
                "holds " + text + " files; which are the scans is not known",
                "Keep one kind in the folder.");
  }
  std::sort(names.begin(), names.end(), natural_less);
  for (const std::string& name : names) entries_.push_back({(fs::path(path_) / name).string(), {}});
  return {};
}

Status ScanFolder::read_times() {
  const auto times = read_times_txt(*times_path_);
  if (!times) return tl::make_unexpected(times.error());
  const std::size_t scans = entries_.size();
  if (times->size() < scans || times->size() > scans + kSurplusTimesMax) {
    return fail(ErrorCode::kInput, *times_path_,
                fmt::format("has {} stamps for {} scans", times->size(), scans),
                "There must be one line for each scan.");
  }
  if (times->size() > scans) {
    add_finding("scans.times",
                fmt::format("{}: has {} stamps for {} scans; the last {} are not used",
                            *times_path_, times->size(), scans, times->size() - scans),
                static_cast<double>(times->size() - scans));
  }
  for (std::size_t i = 0; i < scans; ++i) entries_[i].t = (*times)[i];
  return {};
}

void ScanFolder::assume_times() {
  times_assumed_ = true;
  Time t;
  for (ScanEntry& entry : entries_) {
    entry.t = t;
    t = t + kAssumedPeriod;
  }
  add_finding("scans.times", path_ + ": no times.txt; 10 scans a second are assumed", 10.0);
}

void ScanFolder::add_finding(const char* id, std::string text, double value) {
  Finding finding;
  finding.id = id;
  finding.text = std::move(text);
  finding.value = value;
  findings_.push_back(std::move(finding));
}

Error ScanFolder::none_readable() const {
  std::string why;
  for (const Finding& f : findings_) {
    if (why.empty() && f.id == "scans.damaged") why = f.text;
  }
  return {ErrorCode::kInput, fmt::format("none of its {} can be read", counted(skipped_, "cloud")),
          path_, why.empty() ? "" : "The first: " + why + '.'};
}

void ScanFolder::rewind() {
  next_ = 0;
  skipped_ = 0;
  // Findings from reading will be found again.
  std::erase_if(findings_, [](const Finding& f) { return f.id != "scans.times"; });
  named_ = 0;
}

Result<bool> ScanFolder::next(CloudFile& cloud, Time& t) {
  while (next_ < entries_.size()) {
    const ScanEntry& entry = entries_[next_++];
    auto read = read_cloud_file(entry.path, options_);
    if (read) {
      for (const Finding& finding : read->findings) {
        if (named_++ < kNamedMax) findings_.push_back(finding);
      }
      cloud = std::move(*read);
      t = entry.t;
      return true;
    }
    if (read.error().code == ErrorCode::kMachine) return tl::make_unexpected(read.error());
    ++skipped_;
    // A folder of another kind must not produce a thousand findings.
    if (named_++ < kNamedMax) {
      add_finding("scans.damaged", read.error().message() + " The scan is left out",
                  static_cast<double>(next_ - 1));
    }
  }
  return false;
}

}  // namespace rali::io
