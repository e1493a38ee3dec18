#include <algorithm>
#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include "rali/drive/internal/map_run_stages.hpp"
#include "rali/drive/output/degenerate_findings.hpp"
#include "rali/drive/output/final_path.hpp"
#include "rali/drive/output/imu_path.hpp"
#include "rali/drive/output/map_files.hpp"
#include "rali/drive/output/metrics.hpp"
#include "rali/drive/output/out_dir.hpp"
#include "rali/drive/output/rounds_files.hpp"
#include "rali/drive/output/run_monitor.hpp"
#include "rali/drive/output/session_fleet.hpp"
#include "rali/drive/output/vehicle_files.hpp"
#include "rali/drive/ranges/range_findings.hpp"
#include "rali/drive/run_findings.hpp"
#include "rali/io/files/atomic_file.hpp"

namespace rali::drive::internal {

Status MapRun::write_results() {
  const std::vector<std::string> names = vehicle_names(job_);
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    if (runs_[i].poses().empty()) {
      report(no_pose_finding(runs_[i].name(), summary_.vehicles[i].input));
      summary_.gaps = true;
    }
    summary_.gaps |= summary_.vehicles[i].diverged_s > 0.0;
    for (Finding& f : degenerate_findings(runs_[i].poses(), runs_[i].name())) report(std::move(f));
    if (Status s = write_vehicle_files(runs_[i], job_.out_dir, names); !s) return s;
    if (Status s = write_imu_rate(i); !s) return s;
  }
  for (Finding& f : fleet_findings(summary_.fleet, names)) report(std::move(f));
  summary_.gaps |= !is_connected(summary_.fleet);
  if (Status s = write_fleet_files(runs_, summary_.fleet, job_); !s) return s;
  if (Status s = write_ranges(); !s) return s;
  log_.stage("trajectories");
  if (Status s = write_map(); !s) return s;
  if (Status s = check_results(); !s) return s;
  return write_rounds();
}

/// Writes trajectory/<v>.imu.tum, if requested and if there are samples.
Status MapRun::write_imu_rate(std::size_t index) {
  if (!job_.imu_rate) return {};
  const VehicleRun& run = runs_[index];
  if (run.imu_samples().empty()) {
    report(no_imu_rate_finding(run.name()));
    return {};
  }
  return write_imu_path(job_.out_dir + "/trajectory/" + run.name() + ".imu.tum", run.poses(),
                        run.map_frame(), run.name(), run.imu_samples(),
                        summary_.vehicles[index].input.T_body_imu);
}

/// Checks that do not share the estimator's assumptions. Contradicted poses get larger covariances,
/// and their files are written once more.
Status MapRun::check_results() {
  Result<MonitorResult> checked = monitor_run(runs_, summary_.fleet, looks_, job_, *executor_);
  if (!checked) return tl::make_unexpected(checked.error());
  for (Finding& f : checked->findings) report(std::move(f));
  summary_.checks = checked->tally;
  summary_.gaps |= checked->map_contradicts_itself;
  const std::vector<std::string> names = vehicle_names(job_);
  for (const VehicleId id : checked->widened) {
    const VehicleRun& run = runs_[id.value];
    if (Status s = write_vehicle_files(run, job_.out_dir, names); !s) return s;
    run.summarise(summary_.vehicles[id.value]);
  }
  log_.stage("checks");
  return {};
}

Status MapRun::write_ranges() {
  const RangeOptions& ranges = job_.ranges;
  const bool named = !ranges.files.empty() || !ranges.topics.empty() || !ranges.serial_logs.empty();
  if (!named && range_log_.empty()) return {};
  summary_.ranges = range_log_.tally();
  std::vector<InputReport> reports;
  for (const VehicleSummary& v : summary_.vehicles) reports.push_back(v.input);
  const std::vector<fleet::VehicleFrame>& frames = summary_.fleet.frames;
  const bool placing =
      std::any_of(frames.begin(), frames.end(), [](const fleet::VehicleFrame& frame) {
        return frame.decided_by == fleet::DecidedBy::kRanges ||
               frame.decided_by == fleet::DecidedBy::kRangesAndScans;
      });
  for (Finding& f : range_findings(summary_.ranges, job_, reports, placing)) report(std::move(f));
  return range_log_.write(job_.out_dir + "/ranges.csv");
}

/// Finds the pose of the map on the site, from the marks over which its vehicles stood.
void MapRun::find_site(const std::vector<const VehicleRun*>& mapped) {
  if (job_.marks.empty()) return;
  std::vector<MarkPair> pairs;
  for (const SiteMark& mark : job_.marks) {
    const VehicleRun& run = runs_[mark.vehicle.value];
    const bool in_map = std::find(mapped.begin(), mapped.end(), &run) != mapped.end();
    const auto T_map_body = FinalPath(run.poses(), run.T_map_local()).at(mark.t);
    if (in_map && T_map_body) {
      pairs.push_back({run.name(), mark.t, T_map_body->p, mark.p_site_m, mark.sigma_m});
      continue;
    }
    report(lost_mark_finding(run.name(), mark.t, in_map));
  }
  const Result<SiteFrame> site = solve_site(pairs);
  if (site) {
    summary_.site = *site;
    report(site_finding(*site));
    return;
  }
  report(no_site_finding(site.error()));
  summary_.gaps = true;
}

Status MapRun::write_map() {
  const std::vector<const VehicleRun*> mapped = mapped_runs(runs_, summary_.fleet);
  if (mapped.empty()) {
    report(no_map_finding());
    summary_.gaps = true;
    return {};
  }
  Progress progress;
  progress.vehicle = mapped.front()->name();
  progress.stage = "map";
  sink_.progress(progress);
  find_site(mapped);
  FindingList findings;
  Result<MapNumbers> numbers = write_map_files(mapped, job_, summary_.site, *executor_, findings);
  for (Finding& f : findings) report(std::move(f));
  if (!numbers) return tl::make_unexpected(numbers.error());
  summary_.map_points = numbers->points;
  summary_.removed_points = numbers->removed;
  summary_.map_thickness_m = numbers->thickness_m;
  looks_ = std::move(numbers->looks);
  log_.stage("map");
  return {};
}

/// Writes the rounds of the fleet.
Status MapRun::write_rounds() {
  const FleetRunView fleet{&runs_, mapped_runs(runs_, summary_.fleet), job_.out_dir};
  FindingList findings;
  Result<std::vector<fleet::RoundRow>> rounds =
      write_fleet_story(fleet, job_, summary_.fleet, range_log_, session_.get(), findings);
  for (Finding& f : findings) report(std::move(f));
  if (!rounds) return tl::make_unexpected(rounds.error());
  summary_.rounds = std::move(*rounds);
  log_.stage("rounds");
  return {};
}

/// Unless keyframes are requested, their clouds were only needed for the map.
void MapRun::forget_keyframes() {
  if (job_.write_keyframes) return;
  for (const VehicleRun& run : runs_) remove_keyframes(job_.out_dir, run.name(), run.keyframes());
  std::error_code ignored;
  std::filesystem::remove(job_.out_dir + "/keyframes", ignored);
}

/// Numbers, settings, log and status: written for complete and for failed runs.
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
    for (std::size_t i = 0; i < summary_.vehicles.size(); ++i) {
      reports[i].range_latency = summary_.vehicles[i].input.range_latency;
    }
    status = io::write_file_atomic(job_.out_dir + "/settings.yaml", job_.settings_text(reports));
  }
  log_.stage("files");
  if (!so_far) log_.line("error: " + so_far.error().message());
  log_.line(status_name(summary_.status));
  if (const Status s = log_.write(job_.out_dir, data_seconds(summary_)); status) status = s;
  const Status last = write_status(job_.out_dir, status_name(summary_.status), true);
  return status ? last : status;
}

void MapRun::give_up(std::string_view fault) noexcept {
  if (!started_) return;
  try {
    session_.reset();  // unfinished files go before the folder is listed
    log_.line(fmt::format("internal fault: {}", fault));
    log_.line(status_name(RunStatus::kFailed));
    // Write errors are ignored: the caller must learn of the fault itself.
    static_cast<void>(log_.write(job_.out_dir, data_seconds(summary_)));
    static_cast<void>(write_status(job_.out_dir, status_name(RunStatus::kFailed), true));
  } catch (...) {
    return;
  }
}

}  // namespace rali::drive::internal
