#include "rali/drive/map_run.hpp"

#include <exception>
#include <utility>

#include "rali/drive/fact_path.hpp"
#include "rali/drive/fleet_rounds.hpp"
#include "rali/drive/internal/map_run_stages.hpp"
#include "rali/drive/live/live_map.hpp"
#include "rali/drive/measured.hpp"
#include "rali/drive/open_events.hpp"
#include "rali/drive/output/joint_path.hpp"
#include "rali/drive/output/out_dir.hpp"
#include "rali/drive/run_findings.hpp"

namespace rali::drive {
namespace internal {

void MapRun::report(Finding finding) {
  sink_.finding(finding);
  log_.finding(finding);
  summary_.findings.push_back(std::move(finding));
}

Status MapRun::open_sources() {
  for (std::size_t i = 0; job_.facts && i < job_.vehicles.size(); ++i) {
    sources_.push_back(fact_source(*job_.facts, i));
  }
  if (job_.facts) return {};
  for (std::size_t i = 0; i < job_.vehicles.size(); ++i) {
    Result<std::unique_ptr<ReportedSource>> source = open_events(member_job(job_, i, ranges_));
    if (!source) return tl::make_unexpected(source.error());
    sources_.push_back(std::move(*source));
  }
  Result<RangeList> ranges = read_range_files(job_.ranges, clock_offsets_s());
  if (!ranges) return tl::make_unexpected(ranges.error());
  range_list_ = std::move(*ranges);
  range_log_.name_strangers(range_list_.strangers);
  return {};
}

Status MapRun::open_session() {
  if (!job_.write_mcap) return {};
  Result<std::unique_ptr<SessionFile>> session = SessionFile::create(job_.out_dir);
  if (!session) return tl::make_unexpected(session.error());
  session_ = std::move(*session);
  return {};
}

Status MapRun::start_vehicles() {
  runs_.reserve(job_.vehicles.size());  // the loop points into it
  for (std::size_t i = 0; i < job_.vehicles.size(); ++i) {
    const InputReport& first = sources_[i]->report();
    for (const Finding& f : first.findings) report(f);
    findings_reported_.push_back(first.findings.size());
    vehicles_.emplace_back(VehicleId{static_cast<std::uint16_t>(i)},
                           settings_with(job_.vehicles[i].settings, first));
    if (session_) session_->set_lidar(first.vehicle, first.T_body_lidar);
    Result<VehicleRun> run = VehicleRun::start(first.vehicle, job_.out_dir, session_.get());
    if (!run) return tl::make_unexpected(run.error());
    if (job_.imu_rate) run->keep_imu();
    if (job_.point == OutputPoint::kLidar) run->set_point("lidar", first.T_body_lidar);
    if (job_.point == OutputPoint::kImu) run->set_point("imu", first.T_body_imu);
    runs_.push_back(std::move(*run));
  }
  return {};
}

Status MapRun::run_vehicles() {
  if (Status s = start_vehicles(); !s) return s;
  std::vector<FleetMember> members(job_.vehicles.size());
  for (std::size_t i = 0; i < members.size(); ++i) {
    members[i].source = sources_[i].get();
    members[i].step = [&vehicle = vehicles_[i]](const vehicle::Event& event, Executor& executor,
                                                vehicle::OutputList& out) {
      vehicle.step(event, executor, out);
    };
    members[i].run = &runs_[i];
  }
  LiveMap live(members.size(), job_.fleet, job_.known);
  run_fleet(members, range_list_.samples, job_.ranges,
            {threads_ > 1, job_.strict, !job_.known.common_clock}, *executor_, range_log_, &live,
            sink_, stop_);
  log_.stage("odometry");
  join_fleet();
  log_.stage("fleet");
  check_clocks();
  log_.stage("clock check");
  Status status;
  for (std::size_t i = 0; i < members.size(); ++i) {
    const Status finished = finish_vehicle(i, members[i]);
    if (status) status = finished;
  }
  const Status ended = judge_ends(members);
  return ended ? status : ended;
}

/// Joins all reported facts into one map.
void MapRun::join_fleet() {
  Progress progress;
  progress.stage = "fleet";
  sink_.progress(progress);
  summary_.fleet = estimate_fleet(runs_, job_, *executor_);
  add_absent(runs_.size(), summary_.fleet);
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    join_path(summary_.fleet, VehicleId{static_cast<std::uint16_t>(i)}, runs_[i]);
  }
  share_levels(summary_.fleet, runs_);
}

Status MapRun::finish_vehicle(std::size_t index, const FleetMember& member) {
  for (const Finding& f : member.findings) {
    log_.finding(f);
    summary_.findings.push_back(f);
  }
  VehicleSummary vehicle;
  vehicle.input = sources_[index]->report();
  vehicle.name = vehicle.input.vehicle;
  if (!job_.facts) take_measured(vehicles_[index], job_.vehicles[index].settings, vehicle);
  const FindingList& all = vehicle.input.findings;
  for (std::size_t k = findings_reported_[index]; k < all.size(); ++k) report(all[k]);
  const std::size_t posed = runs_[index].poses().size();
  vehicle.scans_dropped = vehicle.input.scans > posed ? vehicle.input.scans - posed : 0;
  summary_.gaps |= vehicle.input.gaps.damaged;
  interrupted_ |= member.end.interrupted;
  summary_.vehicles.push_back(std::move(vehicle));
  if (auto gyro = gyro_finding(runs_[index], sources_[index]->report())) report(std::move(*gyro));
  for (Finding& f : noise_findings(summary_.vehicles.back())) report(std::move(f));
  const Status finished = runs_[index].finish();
  runs_[index].summarise(summary_.vehicles.back());
  return finished;
}

/// Unreadable data of one vehicle are a gap as long as another has a result; a full disk is not.
Status MapRun::judge_ends(const std::vector<FleetMember>& members) {
  const Error* last = nullptr;
  std::size_t failed = 0;
  for (const FleetMember& member : members) {
    if (!member.end.error) continue;
    if (member.end.error->code == ErrorCode::kMachine) {
      return tl::make_unexpected(*member.end.error);
    }
    last = &*member.end.error;
    ++failed;
  }
  if (failed == members.size()) return tl::make_unexpected(*last);
  for (const FleetMember& member : members) {
    if (!member.end.error) continue;
    report(failed_finding(member.run->name(), *member.end.error));
    summary_.gaps = true;
  }
  return {};
}

Result<MapSummary> MapRun::run() {
  summary_.out_dir = job_.out_dir;
  log_.line(job_.command_line);
  // Inputs first: a run that cannot start leaves the folder unchanged.
  if (Status s = open_sources(); !s) return tl::make_unexpected(s.error());
  if (Status s = prepare_out_dir(job_.out_dir, job_.overwrite); !s) {
    return tl::make_unexpected(s.error());
  }
  if (Status s = write_status(job_.out_dir, "running", false); !s) {
    return tl::make_unexpected(s.error());
  }
  started_ = true;
  return run_in_folder();
}

Result<MapSummary> MapRun::run_in_folder() {
  log_.stage("open");
  for (const Finding& f : range_list_.findings) report(f);
  Status status = study_turning();
  log_.stage("time offset");
  if (status && job_.find_clock_offsets && !job_.facts) {
    status = find_clock_offsets();
    log_.stage("clock offset");
  }
  if (status) status = open_session();
  if (status) status = job_.facts ? run_facts() : run_vehicles();
  if (status) status = write_results();
  if (status && session_) status = session_->finish();
  if (status) forget_keyframes();
  if (!status) session_.reset();  // its unfinished file frees space for the small ones
  const Status closed = close(status);
  if (!status) return tl::make_unexpected(status.error());
  if (!closed) return tl::make_unexpected(closed.error());
  return std::move(summary_);
}

}  // namespace internal

Result<MapSummary> run_map(const MapJob& job, ProgressSink& sink, const std::atomic<bool>& stop) {
  if (job.vehicles.empty()) return fail(ErrorCode::kUsage, "", "no vehicle to map");
  internal::MapRun run(job, sink, stop);
  try {
    return run.run();
  } catch (const std::exception& fault) {
    run.give_up(fault.what());
    throw;
  } catch (...) {
    run.give_up("of unknown kind");
    throw;
  }
}

}  // namespace rali::drive
