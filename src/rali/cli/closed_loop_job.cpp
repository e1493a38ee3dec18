#include "rali/cli/closed_loop_job.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "rali/cli/progress_view.hpp"
#include "rali/cli/record_mission.hpp"
#include "rali/config/apply.hpp"
#include "rali/config/load_fleet.hpp"
#include "rali/drive/output/rounds_table.hpp"
#include "rali/drive/output/traffic_file.hpp"
#include "rali/jobs/map_job.hpp"
#include "rali/scenario/recording/fleet_yaml.hpp"
#include "rali/scenario/vehicle_names.hpp"

namespace rali::cli {
namespace {

constexpr std::string_view kLinkKeys = "link.", kComputerKeys = "sim.", kSettingsKeys = "settings.";

/// The text without the line that begins with `begin`: it names a file that is written later.
std::string without_line(std::string text, std::string_view begin) {
  const std::size_t at = text.find("\n" + std::string(begin));
  if (at == std::string::npos) return text;
  return text.erase(at + 1, text.find('\n', at + 1) - at);
}

/// Assigns keys of radio and computers to `fleet`, the others to `overrides`.
Status assign(const std::vector<std::string>& assignments, drive::FleetNodesSetup& fleet,
              config::Overrides& overrides) {
  config::FieldList fields;
  config::collect_fields(std::string(kLinkKeys), fleet.link, fields);
  config::collect_fields(std::string(kComputerKeys), fleet.computer, fields);
  config::Origins origins;
  for (const std::string& assignment : assignments) {
    if (assignment.starts_with(kSettingsKeys)) {
      overrides.assignments.push_back(assignment);
      continue;
    }
    const Result<config::Node> map = config::parse_assignment(assignment);
    if (!map) return tl::make_unexpected(map.error());
    Status applied = config::apply_map(*map, "", "command line", fields, origins);
    if (!applied) return applied;
  }
  return {};
}

/// The software's configuration, the same as `rali map` would get from the recording's fleet.yaml.
Result<drive::ClosedLoopSetup> setup_of(const sim::FleetSimulation& sim,
                                        const scenario::RecordingOptions& options,
                                        const std::vector<std::string>& names,
                                        const std::vector<std::string>& assignments) {
  drive::ClosedLoopSetup setup;
  config::Overrides overrides;
  if (Status s = assign(assignments, setup.fleet, overrides); !s) {
    return tl::make_unexpected(s.error());
  }
  std::string yaml = scenario::fleet_yaml(sim, names, options);
  for (const char* line : {"ranges:", "radio:"}) yaml = without_line(std::move(yaml), line);
  const auto config = config::parse_fleet(yaml, "fleet.yaml", options.folder, overrides);
  if (!config) return tl::make_unexpected(config.error());
  const auto job = jobs::make_map_job(*config, {});
  if (!job) return tl::make_unexpected(job.error());
  for (const drive::VehicleJob& vehicle : job->vehicles) {
    setup.vehicles.push_back(vehicle.settings);
    setup.fleet.names.push_back(vehicle.settings.name);
  }
  setup.fleet.node = config->settings.mission;
  setup.fleet.node.take(job->fleet);
  setup.fleet.known = job->known;
  setup.fleet.seed = options.seed;
  return setup;
}

/// A vehicle without data link neither sends nor receives; the recording has no trace of messages.
void cut_radios(const std::vector<scenario::Fault>& faults, Time t_start, drive::Loopback& radio) {
  for (const scenario::Fault& fault : faults) {
    if (fault.kind != scenario::FaultKind::kRadioLoss) continue;
    radio.cut_off(VehicleId{static_cast<std::uint16_t>(fault.vehicle)},
                  t_start + Duration::from_s(fault.t0_s), t_start + Duration::from_s(fault.t1_s));
  }
}

/// Shows the progress of the mission.
class MissionView {
 public:
  MissionView(Session& session, const sim::FleetSimulation& sim,
              const drive::ClosedLoopFleet& fleet, double time_limit_s)
      : session_(session), view_(session), sim_(sim), fleet_(fleet), limit_s_(time_limit_s) {
    progress_.vehicle = fmt::format("{} vehicles", fleet.nodes().size());
    progress_.stage = "mission";
  }

  void show(Time now) {
    progress_.fraction = std::min(1.0, seconds_between(sim_.t_start(), now) / limit_s_);
    progress_.path_m = 0.0;
    for (int v = 0; v < sim_.vehicles(); ++v) progress_.path_m += sim_.path_m(v);
    view_.progress(progress_);
    report_rounds(now);
  }

 private:
  void report_rounds(Time now) {
    const std::vector<fleet::RoundRow> rounds = fleet_.log().rounds;
    if (rounds.size() <= reported_) return;
    reported_ = rounds.size();
    session_.detail(fmt::format("{:.0f} s: round {}, anchor v{}",
                                seconds_between(sim_.t_start(), now), reported_,
                                rounds.back().anchor.value + 1));
  }

  Session& session_;
  ProgressView view_;
  const sim::FleetSimulation& sim_;
  const drive::ClosedLoopFleet& fleet_;
  double limit_s_;
  drive::Progress progress_;
  std::size_t reported_ = 0;
};

/// Reports the durations of steps and jobs: steps must be short, and JobCost is fitted to the jobs.
void report_times(const drive::FleetNodes& nodes, Session& session) {
  for (const std::string& line : nodes.step_times().lines()) session.detail("steps by " + line);
  for (const drive::SimulatedJobs::Spent& job : nodes.jobs().spent()) {
    session.detail(fmt::format(
        "job: {} nodes, {} submaps, {} pairs, {} cells drawn, {} searched: {:.4f} s of CPU",
        job.work.nodes, job.work.submaps, job.work.compared, job.work.cells_drawn,
        job.work.cells_searched, job.cpu_s));
  }
}

}  // namespace

Result<ClosedLoopRun> run_closed_loop_job(sim::FleetSimulation& sim,
                                          const scenario::RecordingOptions& options,
                                          const std::vector<std::string>& assignments,
                                          double time_limit_s, Executor& executor,
                                          Session& session) {
  const std::vector<std::string> names = scenario::vehicle_names(sim.vehicles());
  const Result<drive::ClosedLoopSetup> setup = setup_of(sim, options, names, assignments);
  if (!setup) return tl::make_unexpected(setup.error());
  drive::ClosedLoopFleet fleet(*setup, sim.t_start(), executor);
  cut_radios(options.faults, sim.t_start(), fleet.nodes().radio());
  MissionView view(session, sim, fleet, time_limit_s);
  auto recording = record_mission(sim, options, fleet, time_limit_s, [&](Time now) {
    view.show(now);
    for (const Finding& finding : fleet.take_findings()) session.detail(finding_line(finding));
  });
  if (!recording) return tl::make_unexpected(recording.error());
  ClosedLoopRun run{std::move(*recording), fleet.log()};
  report_times(fleet.nodes(), session);
  if (Status s = drive::write_rounds_table(options.folder, names, run.mission.rounds,
                                           run.mission.frontiers);
      !s) {
    return tl::make_unexpected(s.error());
  }
  if (Status s = drive::write_traffic_table(options.folder, names, run.mission.reported,
                                            (sim.t_end() - sim.t_start()).s());
      !s) {
    return tl::make_unexpected(s.error());
  }
  return run;
}

bool is_mission_key(std::string_view assignment) {
  return assignment.starts_with(kLinkKeys) || assignment.starts_with(kComputerKeys) ||
         assignment.starts_with(kSettingsKeys);
}

Result<std::vector<std::string>> check_mission_settings(
    const std::vector<std::string>& assignments) {
  drive::FleetNodesSetup fleet;
  config::Overrides overrides;
  Status assigned = assign(assignments, fleet, overrides);
  if (!assigned) return tl::make_unexpected(assigned.error());
  constexpr std::string_view kAnyFleet = "vehicles: {v1: {recording: v1.mcap}}\n";
  const auto config = config::parse_fleet(kAnyFleet, "fleet.yaml", ".", overrides);
  if (!config) return tl::make_unexpected(config.error());
  return config->notices;
}

namespace {

/// The reasons of the remaining frontiers, each with its count.
std::string reasons_text(const std::vector<const fleet::FrontierRow*>& left) {
  std::map<std::string, std::size_t> counts;
  for (const fleet::FrontierRow* f : left) ++counts[f->reason];
  std::string text;
  for (const auto& [reason, count] : counts) {
    text += fmt::format("  {} of them: {}\n", count, reason);
  }
  return text;
}

}  // namespace

std::string mission_text(const drive::MissionLog& mission, double duration_s) {
  const std::size_t rounds = mission.rounds.size();
  std::string text =
      fmt::format("{} round{} in {:.0f} s: ", rounds, rounds == 1 ? "" : "s", duration_s);
  std::vector<const fleet::FrontierRow*> left;
  for (const fleet::FrontierRow& f : mission.frontiers) {
    if (f.round == rounds && f.state == map::FrontierState::kOpen) left.push_back(&f);
  }
  if (!mission.ended) {
    text += "it was ended by its time before everything was explored\n";
  } else if (mission.explored) {
    text += "no frontier is left, everything is explored\n";
  } else {
    text += fmt::format("no vehicle could reach more: {} frontier{} left (see frontiers.csv)\n",
                        left.size(), left.size() == 1 ? " is" : "s are");
    text += reasons_text(left);
  }
  std::uint64_t maximum = 0;
  for (const fleet::TrafficCount& reported : mission.reported)
    maximum = std::max(maximum, reported.total().bytes);
  text += fmt::format("by radio: at most {:.2f} MB per minute and vehicle (traffic.csv)\n",
                      drive::mb_per_min(maximum, duration_s));
  return text;
}

}  // namespace rali::cli
