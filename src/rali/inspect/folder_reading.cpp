#include "rali/inspect/folder_reading.hpp"

#include <optional>
#include <utility>

#include <fmt/format.h>

#include "rali/base/counted.hpp"
#include "rali/inspect/make_finding.hpp"
#include "rali/io/files/imu_csv.hpp"
#include "rali/io/files/scan_folder.hpp"

namespace rali::inspect {
namespace {

/// A larger fraction of unreadable clouds spoils the map.
constexpr double kDamagedMax = 0.2;

bool is_over(const DoctorOptions& options, Time t_first, Time t) {
  return options.seconds > 0.0 && t.s() - t_first.s() > options.seconds;
}

/// @return the time of the last scan examined
Result<Time> read_scans(const DoctorOptions& options, io::ScanFolder& folder,
                        Examination& examination) {
  const Time t_first = folder.entries().front().t;
  Time last = t_first;
  while (true) {
    io::CloudFile cloud;
    Time t;
    const Result<bool> more = folder.next(cloud, t);
    if (!more) return tl::make_unexpected(more.error());
    if (!*more || is_over(options, t_first, t)) return last;
    last = t;
    // Assumed times start at 0, which would count as a stamp that was never set.
    if (folder.times_assumed()) t = t + Duration::from_s(1.0);
    // The view points to the bytes; moving the vector does not relocate them.
    wire::CloudView view = cloud.view(t, "lidar");
    examination.add_cloud(std::move(cloud.data), std::move(view), t);
  }
}

Status read_imu(const DoctorOptions& options, const std::string& path, Time t_first,
                Examination& examination, DoctorReport& report) {
  Result<io::ImuCsvReader> csv = io::ImuCsvReader::open(path);
  if (!csv) return tl::make_unexpected(csv.error());
  while (true) {
    sensor::ImuSample sample;
    const Result<bool> more = csv->next(sample);
    if (!more) return tl::make_unexpected(more.error());
    if (!*more || is_over(options, t_first, sample.t)) break;
    examination.add_imu(sample, sample.t);
  }
  for (Finding finding : csv->findings()) {
    finding.id = "D10";
    finding.topic = path;
    report.findings.push_back(std::move(finding));
  }
  return {};
}

void report_damage(const io::ScanFolder& folder, DoctorReport& report) {
  std::string first;
  for (Finding finding : folder.findings()) {
    if (first.empty() && finding.id == "scans.damaged") first = finding.text;
    // Damaged scans are reported by one sentence below.
    if (finding.id == "scans.damaged") continue;
    finding.id = finding.id == "scans.times" ? "D04" : "D19";
    report.findings.push_back(std::move(finding));
  }
  if (folder.skipped() == 0) return;
  const double fraction =
      static_cast<double>(folder.skipped()) / static_cast<double>(folder.entries().size());
  report.findings.push_back(make_finding(
      "D19", fraction > kDamagedMax ? Severity::kError : Severity::kWarning, folder.path(),
      {fmt::format("{} of {} cannot be read; the first: {}", folder.skipped(),
                   counted(folder.entries().size(), "cloud"), first),
       "they are missing in the map", ""},
      {fraction, kDamagedMax}));
}

}  // namespace

Result<ReadingEnd> read_scan_folder(const DoctorOptions& options, Examination& examination,
                                    DoctorReport& report) {
  Result<io::ScanFolder> folder = io::ScanFolder::open(options.path);
  if (!folder) return tl::make_unexpected(folder.error());
  const Time t_first = folder->entries().front().t;
  report.lidar_topic = options.path;
  const Result<Time> t_last = read_scans(options, *folder, examination);
  if (!t_last) return tl::make_unexpected(t_last.error());
  if (examination.clouds() == 0) return tl::make_unexpected(folder->none_readable());
  const bool no_imu = options.imu_topic == "none";
  const std::string imu =
      no_imu ? "" : (options.imu_file.empty() ? folder->imu_path().value_or("") : options.imu_file);
  if (!imu.empty()) {
    report.imu_topic = imu;
    if (Status s = read_imu(options, imu, t_first, examination, report); !s) {
      return tl::make_unexpected(s.error());
    }
  }
  report_damage(*folder, report);
  report.T_body_lidar = options.T_body_lidar;
  return ReadingEnd{seconds_between(t_first, *t_last)};
}

}  // namespace rali::inspect
