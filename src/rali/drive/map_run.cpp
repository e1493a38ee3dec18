#include "rali/drive/map_run.hpp"

#include <algorithm>
#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include "rali/base/counted.hpp"
#include "rali/drive/event_loop.hpp"
#include "rali/drive/offset/time_offset.hpp"
#include "rali/drive/open_events.hpp"
#include "rali/drive/output/map_files.hpp"
#include "rali/drive/output/metrics.hpp"
#include "rali/drive/output/out_dir.hpp"
#include "rali/drive/output/vehicle_files.hpp"
#include "rali/drive/run_log.hpp"
#include "rali/drive/tbb_executor.hpp"
#include "rali/io/files/atomic_file.hpp"

namespace rali::drive {
namespace {

/// Below or above this the gyro does not turn as the LiDAR does; a tenth is LiDAR noise at slow
/// turns, a factor of two is no noise.
constexpr double kGyroRatioMin = 0.5, kGyroRatioMax = 2.0;

/// One run of `rali map`: the stages in their order. Each stage adds to `summary_`.
class MapRun {
 public:
  MapRun(const MapJob& job, ProgressSink& sink, const std::atomic<bool>& stop)
      : job_(job),
        sink_(sink),
        stop_(stop),
        threads_(job.threads > 0 ? job.threads : cores()),
        executor_(make_executor(threads_)) {}

  Result<MapSummary> run();

 private:
  Status open_sources();
  Status find_time_offset(std::size_t index);
  Status open_session();
  void forget_keyframes();
  Status run_vehicles();
  void finish_vehicle(std::size_t index, const LoopEnd& end);
  void gyro_finding(std::size_t index);
  Status write_results();
  Status write_map();
  Status close(const Status& so_far);
  void report(Finding finding);
  double data_s() const;

  const MapJob& job_;
  ProgressSink& sink_;
  const std::atomic<bool>& stop_;
  int threads_;
  std::unique_ptr<Executor> executor_;
  std::vector<std::unique_ptr<ReportedSource>> sources_;
  std::unique_ptr<SessionFile> session_;
  std::vector<VehicleRun> runs_;
  MapSummary summary_;
  RunLog log_;
  bool interrupted_ = false;
};

void MapRun::report(Finding finding) {
  sink_.finding(finding);
  log_.finding(finding);
  summary_.findings.push_back(std::move(finding));
}

double MapRun::data_s() const {
  double sum_s = 0.0;
  for (const VehicleSummary& v : summary_.vehicles) {
    sum_s += seconds_between(v.input.t_begin, v.input.t_end);
  }
  return sum_s;
}

Status MapRun::open_sources() {
  for (const VehicleJob& vehicle : job_.vehicles) {
    VehicleJob strict = vehicle;
    strict.input.strict |= job_.strict;
    Result<std::unique_ptr<ReportedSource>> source = open_events(strict);
    if (!source) return tl::make_unexpected(source.error());
    sources_.push_back(std::move(*source));
  }
  return {};
}

/// Estimates what is asked for and opens the source once more with it.
Status MapRun::find_time_offset(std::size_t index) {
  VehicleJob job = job_.vehicles[index];
  if (!job.find_time_offset || !sources_[index]->report().has_imu) return {};
  Progress progress;
  progress.vehicle = job.input.vehicle;
  progress.stage = "time offset";
  job.input.lidar_time_offset =
      estimate_time_offset(job, *executor_, threads_ > 1, [&](double share) {
        progress.share = share;
        sink_.progress(progress);
        return !stop_.load(std::memory_order_relaxed);
      });
  job.input.strict |= job_.strict;
  Result<std::unique_ptr<ReportedSource>> source = open_events(job);
  if (!source) return tl::make_unexpected(source.error());
  sources_[index] = std::move(*source);
  report(time_offset_finding(job.input.lidar_time_offset, sources_[index]->report()));
  return {};
}

Status MapRun::open_session() {
  if (!job_.write_mcap) return {};
  Result<std::unique_ptr<SessionFile>> session = SessionFile::create(job_.out_dir);
  if (!session) return tl::make_unexpected(session.error());
  session_ = std::move(*session);
  return {};
}

Status MapRun::run_vehicles() {
  for (std::size_t i = 0; i < job_.vehicles.size(); ++i) {
    ReportedSource& source = *sources_[i];
    const InputReport first = source.report();
    for (const Finding& f : first.findings) report(f);
    vehicle::VehicleSettings settings = job_.vehicles[i].settings;
    settings.name = first.vehicle;
    settings.has_imu = first.has_imu;
    settings.calibration.T_body_lidar = first.T_body_lidar;
    settings.calibration.T_body_imu = first.T_body_imu;
    settings.calibration.lidar_time_offset_s = 0.0;  // applied to the stamps already
    vehicle::Vehicle vehicle(VehicleId{static_cast<std::uint16_t>(i)}, settings);
    if (session_) session_->set_lidar(first.vehicle, first.T_body_lidar);
    Result<VehicleRun> run = VehicleRun::start(first.vehicle, job_.out_dir, session_.get());
    if (!run) return tl::make_unexpected(run.error());
    runs_.push_back(std::move(*run));
    FindingList findings;
    const LoopEnd end = run_events(source, threads_ > 1, job_.strict, vehicle, *executor_,
                                   runs_.back(), findings, sink_, stop_);
    for (const Finding& f : findings) {
      log_.finding(f);
      summary_.findings.push_back(f);
    }
    const FindingList& all = source.report().findings;
    for (std::size_t k = first.findings.size(); k < all.size(); ++k) report(all[k]);
    finish_vehicle(i, end);
    const Status finished = runs_.back().finish();
    runs_.back().summarise(summary_.vehicles.back());
    log_.stage("odometry " + first.vehicle);
    if (end.error) return tl::make_unexpected(*end.error);
    if (!finished) return finished;
    if (end.interrupted) break;
  }
  return {};
}

void MapRun::finish_vehicle(std::size_t index, const LoopEnd& end) {
  VehicleSummary vehicle;
  vehicle.input = sources_[index]->report();
  vehicle.name = vehicle.input.vehicle;
  const std::size_t posed = runs_[index].poses().size();
  vehicle.sweeps_dropped = vehicle.input.sweeps > posed ? vehicle.input.sweeps - posed : 0;
  summary_.gaps |= vehicle.input.gaps.damaged;
  interrupted_ |= end.interrupted;
  summary_.vehicles.push_back(std::move(vehicle));
  gyro_finding(index);
}

void MapRun::gyro_finding(std::size_t index) {
  const double ratio = runs_[index].gyro_ratio();
  if (ratio == 0.0 || (ratio > kGyroRatioMin && ratio < kGyroRatioMax)) return;
  Finding f;
  f.id = "D09";
  f.vehicle = runs_[index].name();
  f.topic = sources_[index]->report().imu_topic;
  f.value = ratio;
  f.limit = kGyroRatioMax;
  f.text = fmt::format("the gyro turned {:.2f} times as much as the LiDAR", ratio);
  f.remedy = ratio > 30.0 ? "Its unit is deg/s: set imu.gyro_unit: deg_s."
                          : "Check imu.gyro_unit and the frame of the IMU.";
  report(std::move(f));
}

Status MapRun::write_results() {
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    if (runs_[i].poses().empty()) {
      Finding f;
      f.id = "map.no_pose";
      f.severity = Severity::kError;
      f.vehicle = runs_[i].name();
      f.text = fmt::format("no pose from {}", counted(summary_.vehicles[i].input.sweeps, "sweep"));
      f.remedy = summary_.vehicles[i].input.sweeps == 0
                     ? "Do start_s and duration_s leave a part of the recording?"
                     : "See run.log for what was refused.";
      report(std::move(f));
      summary_.gaps = true;
    }
    summary_.gaps |= summary_.vehicles[i].diverged_s > 0.0;
    if (Status s = write_vehicle_files(runs_[i], job_.out_dir); !s) return s;
  }
  if (runs_.size() > 1) {
    Finding f;
    f.id = "fleet.not_joined";
    f.text = fmt::format("{} vehicles keep frames of their own: they are mapped one by one",
                         runs_.size());
    f.effect = "map.* holds the vehicle with the most keyframes.";
    report(std::move(f));
    summary_.gaps = true;
  }
  if (Status s = write_fleet_files(runs_, job_); !s) return s;
  log_.stage("trajectories");
  return write_map();
}

Status MapRun::write_map() {
  const auto largest =
      std::max_element(runs_.begin(), runs_.end(), [](const VehicleRun& a, const VehicleRun& b) {
        return a.keyframes().size() < b.keyframes().size();
      });
  const bool any = largest != runs_.end() &&
                   std::any_of(largest->keyframes().begin(), largest->keyframes().end(),
                               [](const KeyframeRecord& k) { return !k.diverged; });
  if (!any) {
    Finding f;
    f.id = "map.empty";
    f.severity = Severity::kError;
    f.text = "no keyframe: there is no map";
    report(std::move(f));
    summary_.gaps = true;
    return {};
  }
  Progress progress;
  progress.vehicle = largest->name();
  progress.stage = "map";
  sink_.progress(progress);
  FindingList findings;
  Result<MapNumbers> numbers = write_map_files(*largest, job_, *executor_, findings);
  for (Finding& f : findings) report(std::move(f));
  if (!numbers) return tl::make_unexpected(numbers.error());
  summary_.map_points = numbers->points;
  summary_.removed_points = numbers->removed;
  summary_.map_thickness_m = numbers->thickness_m;
  log_.stage("map");
  return {};
}

/// Without keyframes asked for, their clouds were only needed for the map.
void MapRun::forget_keyframes() {
  if (job_.write_keyframes) return;
  std::error_code ignored;
  for (const VehicleRun& run : runs_) {
    for (const KeyframeRecord& record : run.keyframes()) {
      std::filesystem::remove(job_.out_dir + '/' + record.file, ignored);
    }
    std::filesystem::remove(job_.out_dir + "/keyframes/" + run.name(), ignored);
  }
  std::filesystem::remove(job_.out_dir + "/keyframes", ignored);
}

/// Numbers, settings, log and status: written for whole and for broken runs alike.
Status MapRun::close(const Status& so_far) {
  summary_.status = !so_far         ? RunStatus::kFailed
                    : interrupted_  ? RunStatus::kInterrupted
                    : summary_.gaps ? RunStatus::kPartial
                                    : RunStatus::kComplete;
  summary_.metrics_json = metrics_text(summary_, job_);
  Status status = io::write_file_atomic(job_.out_dir + "/metrics.json", summary_.metrics_json);
  if (status && job_.settings_text) {
    std::vector<InputReport> reports;
    for (const auto& source : sources_) reports.push_back(source->report());
    status = io::write_file_atomic(job_.out_dir + "/settings.yaml", job_.settings_text(reports));
  }
  log_.stage("files");
  if (!so_far) log_.line("error: " + so_far.error().message());
  log_.line(status_name(summary_.status));
  if (const Status s = log_.write(job_.out_dir, data_s()); status) status = s;
  const Status last = write_status(job_.out_dir, status_name(summary_.status), true);
  return status ? last : status;
}

Result<MapSummary> MapRun::run() {
  summary_.out_dir = job_.out_dir;
  log_.line(job_.command_line);
  // Inputs first: a run that cannot start leaves the folder as it was.
  if (Status s = open_sources(); !s) return tl::make_unexpected(s.error());
  if (Status s = prepare_out_dir(job_.out_dir, job_.overwrite); !s) {
    return tl::make_unexpected(s.error());
  }
  if (Status s = write_status(job_.out_dir, "running", false); !s) {
    return tl::make_unexpected(s.error());
  }
  log_.stage("open");
  if (!job_.ranges_file.empty()) {
    Finding f;
    f.id = "ranges.unused";
    f.topic = job_.ranges_file;
    f.text = fmt::format("{}: ranges are not used: each vehicle is mapped alone", job_.ranges_file);
    report(std::move(f));
  }
  Status status;
  for (std::size_t i = 0; status && i < sources_.size(); ++i) status = find_time_offset(i);
  log_.stage("time offset");
  if (status) status = open_session();
  if (status) status = run_vehicles();
  if (status) status = write_results();
  if (status && session_) status = session_->finish();
  if (status) forget_keyframes();
  if (!status) session_.reset();  // its unfinished file gives room for what is small
  const Status closed = close(status);
  if (!status) return tl::make_unexpected(status.error());
  if (!closed) return tl::make_unexpected(closed.error());
  return std::move(summary_);
}

}  // namespace

Result<MapSummary> run_map(const MapJob& job, ProgressSink& sink, const std::atomic<bool>& stop) {
  if (job.vehicles.empty()) return fail(ErrorCode::kUsage, "", "no vehicle to map");
  return MapRun(job, sink, stop).run();
}

Result<std::vector<InputReport>> plan_map(const MapJob& job) {
  std::vector<InputReport> reports;
  for (const VehicleJob& vehicle : job.vehicles) {
    const Result<std::unique_ptr<ReportedSource>> source = open_events(vehicle);
    if (!source) return tl::make_unexpected(source.error());
    reports.push_back((*source)->report());
  }
  return reports;
}

}  // namespace rali::drive
