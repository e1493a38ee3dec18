#include "rali/drive/folder_events.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "rali/base/counted.hpp"
#include "rali/drive/input/event_outlet.hpp"
#include "rali/drive/input/imu_intake.hpp"
#include "rali/drive/input/recording_probe.hpp"
#include "rali/io/files/imu_csv.hpp"
#include "rali/io/files/scan_folder.hpp"

namespace rali::drive {
namespace {

constexpr std::size_t kScans = 10;
constexpr std::size_t kImuSamples = 20000;
constexpr double kProbeS = 3.0;
/// Inertial data is passed on this far ahead of the scans so that no scan waits for it.
constexpr double kImuLeadS = 0.3;
constexpr std::uint64_t kNamedErrors = 5;

class FolderEvents final : public ReportedSource {
 public:
  FolderEvents(io::ScanFolder folder, std::optional<io::ImuCsvReader> imu, ImuUnits units,
               InputOptions options, InputReport report)
      : folder_(std::move(folder)),
        imu_(std::move(imu)),
        options_(std::move(options)),
        report_(std::move(report)),
        intake_(units),
        outlet_(options_) {}

  Result<std::optional<vehicle::Event>> next() override {
    while (!ended_) {
      std::optional<vehicle::Event> event = outlet_.pop(report_);
      if (event) return event;
      if (exhausted_ || outlet_.past_end()) {
        end();
        continue;
      }
      const Result<bool> more = read_one();
      if (!more) return tl::make_unexpected(more.error());
      if (!*more || (options_.strict && report_.gaps.damaged)) {
        exhausted_ = true;
        outlet_.finish();
      }
    }
    return std::optional<vehicle::Event>();
  }

  double progress() const override {
    return ended_ ? 1.0
                  : static_cast<double>(scans_) / static_cast<double>(folder_.entries().size());
  }

  const InputReport& report() const override { return report_; }

 private:
  Result<bool> read_one() {
    io::CloudFile cloud;
    Time t;
    const Result<bool> got = folder_.next(cloud, t);
    if (!got || !*got) return got;
    ++scans_;
    auto scan = std::make_shared<sensor::LidarScan>();
    if (Status s =
            wire::decode_cloud(cloud.view(t, "lidar"), report_.cloud_format, options_.cloud, *scan);
        !s) {
      damaged(s.error());
      return true;
    }
    if (scan->size() == 0) {
      outlet_.push(std::move(scan));
      return true;
    }
    const Duration offset = Duration::from_s(options_.lidar_time_offset.value_s) + clock_offset();
    scan->t_start = scan->t_start + offset;
    scan->t_end = scan->t_end + offset;
    push_imu_until(scan->t_end + Duration::from_s(kImuLeadS));
    outlet_.push(std::move(scan));
    return true;
  }

  [[nodiscard]] Duration clock_offset() const {
    return Duration::from_s(options_.clock_offset.value_s);
  }

  void push_imu_until(Time t) {
    while (imu_) {
      if (!waiting_) read_imu();
      if (!waiting_) {
        close_imu();
      } else if (waiting_->t > t) {
        return;
      } else {
        // Rows out of order go to the ordering window, which sorts them or counts them as late.
        if (last_imu_ && waiting_->t == *last_imu_) {
          ++report_.gaps.repeated;
        } else {
          last_imu_ = waiting_->t;
          if (const auto sample = intake_.take(*waiting_, report_.gaps)) outlet_.push(*sample);
        }
        waiting_.reset();
      }
    }
  }

  void read_imu() {
    sensor::ImuSample sample;
    const Result<bool> got = imu_->next(sample);
    if (got && *got) {
      waiting_ = sample;
      waiting_->t = sample.t + clock_offset();
    }
    if (got) return;
    report_.gaps.damaged = true;
    Finding f;
    f.id = "D19";
    f.vehicle = report_.vehicle;
    f.topic = report_.imu_topic;
    f.text = got.error().message();
    report_.findings.push_back(std::move(f));
  }

  void close_imu() {
    const io::ImuCsvStats& stats = imu_->stats();
    report_.gaps.imu_invalid += stats.nan_rows + stats.bad_rows;
    if (stats.bad_rows > 0) report_.gaps.damaged = true;
    for (Finding f : imu_->findings()) {
      f.vehicle = report_.vehicle;
      report_.findings.push_back(std::move(f));
    }
    imu_.reset();
  }

  void damaged(const Error& error) {
    report_.gaps.damaged = true;
    if (++report_.gaps.undecodable > kNamedErrors) return;
    Finding f;
    f.id = "D19";
    f.vehicle = report_.vehicle;
    f.topic = folder_.path();
    f.text = fmt::format("scan {} left out: {}", scans_, error.message());
    report_.findings.push_back(std::move(f));
  }

  void end() {
    ended_ = true;
    if (folder_.skipped() > 0) report_.gaps.damaged = true;
    for (const Finding& f : folder_.findings()) report_.gaps.damaged |= f.id == "cloud.cut";
    report_.gaps.undecodable += folder_.skipped();
    for (std::size_t i = known_findings_; i < folder_.findings().size(); ++i) {
      report_.findings.push_back(folder_.findings()[i]);
      report_.findings.back().vehicle = report_.vehicle;
    }
    if (imu_) close_imu();
    outlet_.close(report_);
  }

  io::ScanFolder folder_;
  std::optional<io::ImuCsvReader> imu_;
  InputOptions options_;
  InputReport report_;
  ImuIntake intake_;
  EventOutlet outlet_;
  std::size_t known_findings_ = folder_.findings().size();
  std::optional<sensor::ImuSample> waiting_;
  std::optional<Time> last_imu_;
  std::size_t scans_ = 0;
  bool exhausted_ = false, ended_ = false;
};

/// The first scans, decoded with the format that was determined from them.
Result<std::vector<sensor::LidarScan>> first_scans(io::ScanFolder& folder,
                                                   const InputOptions& options,
                                                   InputReport& report) {
  std::vector<io::CloudFile> clouds;
  std::vector<Time> times;
  while (clouds.size() < kScans) {
    io::CloudFile cloud;
    Time t;
    const Result<bool> got = folder.next(cloud, t);
    if (!got) return tl::make_unexpected(got.error());
    if (!*got) break;
    clouds.push_back(std::move(cloud));
    times.push_back(t);
  }
  if (clouds.empty() && folder.skipped() > 0) return tl::make_unexpected(folder.none_readable());
  std::vector<wire::CloudView> views;
  for (std::size_t i = 0; i < clouds.size(); ++i)
    views.push_back(clouds[i].view(times[i], "lidar"));
  Result<wire::CloudFormat> format = wire::decide_cloud_format(views, options.cloud);
  if (!format) {
    Error error = format.error();
    error.code = ErrorCode::kInput;
    error.where = folder.path() + (error.where.empty() ? "" : ": " + error.where);
    return tl::make_unexpected(std::move(error));
  }
  report.cloud_format = *format;
  for (Finding f : format->findings) {
    f.vehicle = report.vehicle;
    f.topic = folder.path();
    report.findings.push_back(std::move(f));
  }
  std::vector<sensor::LidarScan> scans;
  for (std::size_t i = 0; i < views.size() && scans.size() < 3; ++i) {
    sensor::LidarScan scan;
    if (wire::decode_cloud(views[i], *format, options.cloud, scan))
      scans.push_back(std::move(scan));
  }
  folder.rewind();
  return scans;
}

/// The samples of the first seconds. Reads on until the scans start: without a sample within the
/// scans, the map would be by LiDAR alone while the user takes it for an inertial one.
Result<std::vector<sensor::ImuSample>> first_imu(const std::string& path,
                                                 const io::ScanFolder& folder) {
  std::vector<sensor::ImuSample> samples;
  Result<io::ImuCsvReader> csv = io::ImuCsvReader::open(path);
  if (!csv) return tl::make_unexpected(csv.error());
  const Time t_first = folder.entries().front().t;
  const Time t_last = folder.entries().back().t;
  Time newest;
  std::size_t advancing = 0;
  while (samples.size() < kImuSamples || newest < t_first) {
    sensor::ImuSample sample;
    const Result<bool> got = csv->next(sample);
    if (!got || !*got) break;
    if (!is_plausible(sample) || (advancing > 0 && sample.t <= newest)) continue;
    newest = sample.t;
    ++advancing;
    const bool probed = !samples.empty() && newest.s() - samples.front().t.s() > kProbeS;
    if (!probed && samples.size() < kImuSamples) samples.push_back(sample);
    if (probed && newest >= t_first) break;
  }
  if (advancing < 2) {
    return fail(ErrorCode::kInput, path,
                fmt::format("{} of its {} can be used as inertial samples in order of time",
                            advancing, counted(csv->stats().rows, "row")),
                "Correct it, or map with LiDAR alone by imu.topic: none.");
  }
  if (newest < t_first) {
    return fail(
        ErrorCode::kInput, path,
        fmt::format("ends at {:.3f} s, before the first scan at {:.3f} s", newest.s(), t_first.s()),
        folder.times_assumed() ? "Give times.txt with the stamps of the scans."
                               : "Are both on one clock and in seconds?");
  }
  if (!samples.empty() && samples.front().t > t_last) {
    return fail(ErrorCode::kInput, path,
                fmt::format("starts at {:.3f} s, after the last scan at {:.3f} s",
                            samples.front().t.s(), t_last.s()),
                folder.times_assumed() ? "Give times.txt with the stamps of the scans."
                                       : "Are both on one clock and in seconds?");
  }
  return samples;
}

void no_imu_finding(const std::string& folder, InputReport& report) {
  Finding f;
  f.id = "D10";
  f.severity = Severity::kInfo;
  f.vehicle = report.vehicle;
  f.text = fmt::format(
      "{}{} no imu.csv. Mapping with LiDAR alone; degenerate directions are constrained by "
      "ranges only",
      folder, folder.ends_with('/') ? ":" : "/:");
  report.findings.push_back(std::move(f));
}

}  // namespace

Result<std::unique_ptr<ReportedSource>> open_folder_events(const std::string& path,
                                                           const std::string& imu_file,
                                                           const InputOptions& options) {
  Result<io::ScanFolder> folder = io::ScanFolder::open(path);
  if (!folder) return tl::make_unexpected(folder.error());
  InputReport report;
  report.vehicle = options.vehicle;
  report.files = {path};
  report.lidar_time_offset = options.lidar_time_offset;
  report.clock_offset = options.clock_offset;
  for (const Finding& f : folder->findings()) {
    report.findings.push_back(f);
    report.findings.back().vehicle = options.vehicle;
  }
  const Result<std::vector<sensor::LidarScan>> scans = first_scans(*folder, options, report);
  if (!scans) return tl::make_unexpected(scans.error());

  std::string imu_path = imu_file.empty() ? folder->imu_path().value_or("") : imu_file;
  if (options.imu_topic == "none") imu_path.clear();
  report.has_imu = !imu_path.empty();
  std::optional<io::ImuCsvReader> imu;
  std::vector<sensor::ImuSample> samples;
  if (report.has_imu) {
    report.imu_topic = imu_path;
    Result<std::vector<sensor::ImuSample>> first = first_imu(imu_path, *folder);
    if (!first) return tl::make_unexpected(first.error());
    samples = std::move(*first);
    Result<io::ImuCsvReader> csv = io::ImuCsvReader::open(imu_path);
    if (!csv) return tl::make_unexpected(csv.error());
    imu = std::move(*csv);
  } else {
    no_imu_finding(path, report);
  }
  const Result<ImuUnits> units = decide_imu_units(samples, options, imu_path);
  if (!units) return tl::make_unexpected(units.error());
  report.accel_scale = units->accel_scale;
  report.gyro_scale = units->gyro_scale;
  report.findings.insert(report.findings.end(), units->findings.begin(), units->findings.end());
  if (Status s = decide_extrinsics(options, TfTree{}, *scans, samples, *units, report); !s) {
    return tl::make_unexpected(s.error());
  }
  return std::make_unique<FolderEvents>(std::move(*folder), std::move(imu), *units, options,
                                        std::move(report));
}

}  // namespace rali::drive
