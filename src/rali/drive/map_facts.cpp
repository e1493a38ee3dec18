#include <utility>
#include <vector>

#include "rali/base/finding_of.hpp"
#include "rali/drive/fact_path.hpp"
#include "rali/drive/fleet_rounds.hpp"
#include "rali/drive/internal/map_run_stages.hpp"
#include "rali/drive/output/joint_path.hpp"
#include "rali/drive/state/fleet_facts.hpp"

namespace rali::drive::internal {

/// As run_vehicles(), from the facts that the vehicles sent each other. The estimate comes first:
/// it decides which of a vehicle's starts are connected.
Status MapRun::run_facts() {
  for (const Finding& f : job_.facts->findings) report(f);
  for (Finding& f : missing_findings(*job_.facts)) report(std::move(f));
  report(finding_of("state.left_out", Severity::kInfo,
                    "facts hold a pose about each second and thinned points of the keyframes",
                    "there is no odometry/, no live/ and no scan in session.mcap"));
  for (std::size_t i = 0; i < job_.vehicles.size(); ++i) {
    const InputReport& input = sources_[i]->report();
    findings_reported_.push_back(input.findings.size());
    if (session_) session_->set_lidar(input.vehicle, input.T_body_lidar);
    runs_.push_back(VehicleRun::of_facts(input.vehicle, job_.out_dir, session_.get()));
    if (job_.point == OutputPoint::kLidar) runs_[i].set_point("lidar", input.T_body_lidar);
    if (job_.point == OutputPoint::kImu) runs_[i].set_point("imu", input.T_body_imu);
  }
  if (Status s = fill_runs(); !s) return s;
  Status status;
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    const Status finished = finish_vehicle(i, {});
    if (status) status = finished;
  }
  log_fact_ranges(*job_.facts, runs_, summary_.fleet, range_log_);
  return status;
}

Status MapRun::fill_runs() {
  Progress progress;
  progress.stage = "fleet";
  sink_.progress(progress);
  const FleetFacts& facts = *job_.facts;
  std::vector<ReportedByVehicle> sent;
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    sent.push_back({VehicleId{static_cast<std::uint16_t>(i)}, facts.members[i].facts,
                    sources_[i]->report().t_end, job_.vehicles[i].settings.path.rest_s});
  }
  summary_.fleet = estimate_facts(sent, job_, *executor_);
  FindingList findings;
  const std::vector<StartFrames> frames = keep_one_frame_each(facts, summary_.fleet, findings);
  summary_.gaps |= !findings.empty();
  for (Finding& f : findings) report(std::move(f));
  add_absent(runs_.size(), summary_.fleet);
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    const VehicleId id{static_cast<std::uint16_t>(i)};
    if (Status s = fill_from_facts(facts, id, frames[i], runs_[i]); !s) return s;
    join_path(summary_.fleet, id, runs_[i]);
  }
  share_levels(summary_.fleet, runs_);
  log_.stage("fleet");
  return {};
}

}  // namespace rali::drive::internal
