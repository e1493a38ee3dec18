#include "rali/inspect/doctor.hpp"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include <fmt/format.h>

#include "rali/drive/ranges/range_findings.hpp"
#include "rali/drive/ranges/serial_log.hpp"
#include "rali/inspect/examination.hpp"
#include "rali/inspect/fleet_study.hpp"
#include "rali/inspect/folder_reading.hpp"
#include "rali/inspect/make_finding.hpp"
#include "rali/inspect/recording_reading.hpp"
#include "rali/io/input_kind.hpp"

namespace rali::inspect {
namespace {

/// Bytes of results per usable point: keyframes (one scan in three, 18 bytes), map and copies.
constexpr double kBytesPerPoint = 12.0;
constexpr double kGib = 1024.0 * 1024.0 * 1024.0;

void report_disk(const DoctorOptions& options, double points, double fraction_read,
                 FindingList& out) {
  const double needed = points * kBytesPerPoint / fraction_read;
  double free_bytes = options.disk_free_bytes;
  if (free_bytes < 0.0) {
    std::error_code error;
    const auto space = std::filesystem::space(options.out_dir, error);
    if (error) return;
    free_bytes = static_cast<double>(space.available);
  }
  const bool tight = needed > free_bytes;
  out.push_back(make_finding(
      "D20", tight ? Severity::kWarning : Severity::kInfo, "",
      {fmt::format("the result needs about {:.1f} GiB, {:.1f} GiB are free", needed / kGib,
                   free_bytes / kGib),
       tight ? "the disk fills before the map is done" : "",
       tight ? "Choose another disk with -o, or --no-keyframes, or a larger --map-voxel." : ""},
      {needed / kGib, free_bytes / kGib}));
}

/// Adds the ranges of a serial port, by the names of the fleet.
Status read_serial_log(const drive::SerialLog& log, const RangeInputs& inputs, RangeStudy& ranges,
                       FindingList& findings) {
  Result<drive::SerialRanges> read = drive::read_serial_log(log, inputs.serial);
  if (!read) return tl::make_unexpected(read.error());
  const auto name = [&](VehicleId id) {
    const bool known = id.value < inputs.vehicles.size();
    return known ? inputs.vehicles[id.value] : fmt::format("radio {}", id.value);
  };
  for (const sensor::RangeSample& sample : read->samples) {
    ranges.add(sample.t, name(sample.from), name(sample.to), sample.range_m);
  }
  ranges.add_zeros(read->zeros);
  for (Finding& finding : read->findings) {
    finding.id = "D14";
    findings.push_back(std::move(finding));
  }
  return {};
}

/// Findings of one number come from several functions: errors first, then by number.
void sort_findings(FindingList& findings) {
  std::stable_sort(findings.begin(), findings.end(), [](const Finding& a, const Finding& b) {
    if (a.severity != b.severity) return a.severity > b.severity;
    return a.id < b.id;
  });
}

}  // namespace

bool has_error(const FindingList& findings) {
  return std::any_of(findings.begin(), findings.end(),
                     [](const Finding& f) { return f.severity == Severity::kError; });
}

Result<DoctorReport> examine(const DoctorOptions& options, Executor& executor, RangeStudy& ranges) {
  const Result<io::InputKind> kind = io::input_kind(options.path);
  if (!kind) return tl::make_unexpected(kind.error());
  DoctorReport report;
  report.path = options.path;
  report.vehicle = options.vehicle;
  Examination examination(options, executor);
  const Result<ReadingEnd> end = *kind == io::InputKind::kScanFolder
                                     ? read_scan_folder(options, examination, report)
                                     : read_recording(options, examination, ranges, report);
  if (!end) return tl::make_unexpected(end.error());
  report.seconds = end->data_s;
  examination.finish(report);
  report.t_end = report.t_end + Duration::from_s(end->rest_s);
  report_disk(options, examination.points(), end->fraction_read, report.findings);
  for (Finding& finding : report.findings) finding.vehicle = options.vehicle;
  sort_findings(report.findings);
  return report;
}

Result<FindingList> examine_ranges(const RangeInputs& inputs,
                                   const std::vector<DoctorReport>& recordings,
                                   RangeStudy& ranges) {
  FindingList findings;
  for (const std::string& file : inputs.files) {
    if (const Status status = read_ranges_csv(file, ranges, findings); !status) {
      return tl::make_unexpected(status.error());
    }
  }
  for (const drive::SerialLog& log : inputs.serial.serial_logs) {
    if (const Status status = read_serial_log(log, inputs, ranges, findings); !status) {
      return tl::make_unexpected(status.error());
    }
  }
  for (const std::string& topic : inputs.topics) {
    if (!ranges.has_topic(topic)) findings.push_back(drive::no_topic_finding(topic));
  }
  if (!ranges.empty()) {
    ranges.report("", findings);
    ranges.report_silent(inputs.vehicles, findings);
  }
  ranges.report_strangers(inputs.vehicles, findings);
  report_latency(recordings, ranges, findings);
  report_overlap(recordings, inputs.separate, findings);
  sort_findings(findings);
  return findings;
}

}  // namespace rali::inspect
