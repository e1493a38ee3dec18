#include <algorithm>
#include <filesystem>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "rali/cli/commands/commands.hpp"
#include "rali/cli/map_summary.hpp"
#include "rali/cli/progress_view.hpp"
#include "rali/config/load_fleet.hpp"
#include "rali/drive/run_log.hpp"
#include "rali/jobs/evaluate_job.hpp"
#include "rali/jobs/input_checks.hpp"
#include "rali/jobs/load_inputs.hpp"
#include "rali/jobs/map_job.hpp"
#include "rali/jobs/run_report.hpp"

namespace rali::cli {
namespace {

/// Command line options that set a key of every vehicle.
struct Shortcut {
  std::string option, key, value;
  bool single_only = true;
  bool number = false;  ///< must not be quoted, or it would be text
};

class MapCommand final : public Command {
 public:
  [[nodiscard]] std::string name() const override { return "map"; }

  [[nodiscard]] std::string summary() const override {
    return "map recordings or a live mission: trajectories, cloud, grid, report";
  }

  [[nodiscard]] std::vector<std::string> examples() const override {
    return {"rali map run1.bag", "rali map fleet.yaml --preset paper -o out_paper",
            "rali map fleet.yaml state/v1 state/v2"};
  }

  [[nodiscard]] std::string exit_codes() const override {
    return "0 done, 1 --require not met or no truth at these times, 2 not started, 3 done with "
           "gaps or vehicles not joined, "
           "4 disk or memory, 130 interrupted";
  }

  [[nodiscard]] bool json() const override { return true; }

  [[nodiscard]] Positional positional() override {
    return {
        "INPUT",
        "recordings (.bag .mcap .db3, scan folders) or one fleet.yaml; or state folders of rali "
        "run, with or without their fleet.yaml",
        &inputs_,
        1,
        65,
        {}};
  }

  [[nodiscard]] std::vector<Option> options() override;
  [[nodiscard]] Result<int> run(Session& session) override;

 private:
  [[nodiscard]] std::vector<Shortcut> shortcuts() const;
  [[nodiscard]] Result<jobs::MapInputs> load_with_shortcuts() const;
  [[nodiscard]] Status check_of_facts() const;
  [[nodiscard]] Status read_formats();
  [[nodiscard]] Status check_words(bool json) const;
  [[nodiscard]] std::optional<std::string> judge(Session& session) const;
  [[nodiscard]] Result<int> plan(const config::FleetConfig& fleet, const drive::MapJob& job,
                                 Session& session) const;
  void warn_fleet(const config::FleetConfig& fleet, Session& session) const;

  std::vector<std::string> inputs_, assignments_, requirements_;
  jobs::MapOptions map_;
  std::string preset_, formats_ = "pcd,ply";
  std::string ranges_, radio_, lidar_topic_, imu_topic_, lidar_model_, imu_file_;
  std::string start_s_, duration_s_, map_voxel_m_;
  std::string truth_;
  bool no_mcap_ = false, no_keyframes_ = false, no_report_ = false, dry_run_ = false;
};

std::vector<Option> MapCommand::options() {
  return {
      {"-o,--out", "DIR", "where the results go", &map_.out_dir, false, {}},
      {"--preset",
       "NAME",
       "robust (default) or paper (as printed)",
       &preset_,
       false,
       {"robust", "paper"}},
      {"--set",
       "KEY=VALUE",
       "any setting of docs/reference/settings.md; repeatable",
       &assignments_,
       false,
       {}},
      {"--lidar-topic", "TOPIC", "cloud topic, if there are several", &lidar_topic_, false, {}},
      {"--imu-topic", "TOPIC", "IMU topic; none: LiDAR alone", &imu_topic_, false, {}},
      {"--lidar-model", "NAME", "for point times that are missing", &lidar_model_, true, {}},
      {"--imu", "FILE", "CSV of inertial data of a scan folder", &imu_file_, false, {}},
      {"--ranges", "FILE", "CSV of ranges between the vehicles", &ranges_, true, {}},
      {"--radio", "FILE", "CSV of signal strengths: why rounds end", &radio_, true, {}},
      {"--start", "S", "leave out so much data [s]", &start_s_, false, {}},
      {"--duration", "S", "use so much data [s]; 0: all", &duration_s_, false, {}},
      {"--require", "COND", "max_sigma_m=M, connected; else exit 1", &requirements_, true, {}},
      {"--formats", "LIST", "of map.*: pcd, ply, las", &formats_, false, {}},
      {"--map-voxel",
       "M",
       "one point per cube [m]; 0: all (default 0.05)",
       &map_voxel_m_,
       false,
       {}},
      {"--imu-rate",
       "",
       "also trajectory/<v>.imu.tum, a pose per inertial sample",
       &map_.imu_rate,
       true,
       {}},
      {"--no-mcap", "", "do not write session.mcap", &no_mcap_, true, {}},
      {"--no-keyframes", "", "do not keep the keyframes' clouds", &no_keyframes_, true, {}},
      {"--no-report", "", "do not write report.html", &no_report_, true, {}},
      {"--truth", "DIR", "evaluate at the end, into the report", &truth_, false, {}},
      {"--threads", "N", "0: one per core; results do not depend on it", &map_.threads, true, {}},
      {"--dry-run", "", "read, check, print settings and plan, stop", &dry_run_, false, {}},
      {"--strict", "", "the first gap ends the run with 3", &map_.strict, true, {}},
      {"--overwrite", "", "replace what rali wrote into DIR", &map_.overwrite, false, {}},
  };
}

std::vector<Shortcut> MapCommand::shortcuts() const {
  return {{"--lidar-topic", "lidar.topic", lidar_topic_, true},
          {"--imu-topic", "imu.topic", imu_topic_, true},
          {"--lidar-model", "lidar.model", lidar_model_, true},
          {"--imu", "imu.file", imu_file_, true},
          {"--start", "start_s", start_s_, false, true},
          {"--duration", "duration_s", duration_s_, false, true}};
}

/// The vehicles' names are known only after loading, so shortcuts require a second load.
Result<jobs::MapInputs> MapCommand::load_with_shortcuts() const {
  if (Status s = check_of_facts(); !s) return tl::make_unexpected(s.error());
  config::Overrides overrides{preset_, assignments_};
  if (!map_voxel_m_.empty()) overrides.assignments.push_back("output.map_voxel_m=" + map_voxel_m_);
  if (!ranges_.empty()) {
    overrides.assignments.push_back(
        fmt::format("ranges.sources=[{{file: {}}}]", config::yaml_quoted(ranges_)));
  }
  if (!radio_.empty()) {
    overrides.assignments.push_back("radio.file=" + config::yaml_quoted(radio_));
  }
  Result<jobs::MapInputs> loaded = jobs::load_inputs(inputs_, overrides);
  if (!loaded) return loaded;
  const config::FleetConfig& fleet = loaded->fleet;
  const std::size_t before = overrides.assignments.size();
  for (const Shortcut& shortcut : shortcuts()) {
    if (shortcut.value.empty()) continue;
    if (shortcut.single_only && fleet.vehicles.size() > 1) {
      return fail(ErrorCode::kUsage, shortcut.option,
                  fmt::format("there are {} vehicles", fleet.vehicles.size()),
                  fmt::format("Write vehicles.NAME.{} into a fleet.yaml.", shortcut.key));
    }
    for (const config::VehicleConfig& vehicle : fleet.vehicles) {
      const std::string value =
          shortcut.number ? shortcut.value : config::yaml_quoted(shortcut.value);
      overrides.assignments.push_back(
          fmt::format("vehicles.{}.{}={}", vehicle.name, shortcut.key, value));
    }
  }
  return overrides.assignments.size() == before ? std::move(loaded)
                                                : jobs::load_inputs(inputs_, overrides);
}

/// Options for sensor data have no meaning for the facts that vehicles exchanged.
Status MapCommand::check_of_facts() const {
  if (std::none_of(inputs_.begin(), inputs_.end(), drive::is_state_folder)) return {};
  std::vector<std::pair<std::string, bool>> given = {{"--ranges", !ranges_.empty()},
                                                     {"--imu-rate", map_.imu_rate}};
  for (const Shortcut& shortcut : shortcuts()) {
    given.emplace_back(shortcut.option, !shortcut.value.empty());
  }
  for (const auto& [option, is_given] : given) {
    if (!is_given) continue;
    return fail(ErrorCode::kUsage, option,
                "is for recordings; state folders are mapped as they are",
                "Leave it out, or give recordings.");
  }
  return {};
}

Status MapCommand::read_formats() {
  map_.formats.clear();
  std::size_t begin = 0;
  while (begin <= formats_.size()) {
    const std::size_t comma = std::min(formats_.find(',', begin), formats_.size());
    const std::string format = formats_.substr(begin, comma - begin);
    if (Status s = jobs::check_format(format, "--formats"); !s) return s;
    map_.formats.push_back(format);
    begin = comma + 1;
  }
  return {};
}

void MapCommand::warn_fleet(const config::FleetConfig& fleet, Session& session) const {
  for (const std::string& notice : fleet.notices) session.warning(printable(notice) + '.');
  const std::vector<std::string> idle = jobs::idle_keys(fleet);
  if (!idle.empty()) {
    session.warning(
        fmt::format("{}: checked, but without effect{}.", fmt::join(idle, ", "),
                    fleet.vehicles.size() < 2 ? " on a vehicle alone" : " in this version"));
  }
}

Result<int> MapCommand::plan(const config::FleetConfig& fleet, const drive::MapJob& job,
                             Session& session) const {
  const auto reports = drive::plan_map(job);
  if (!reports) return tl::make_unexpected(reports.error());
  for (const drive::InputReport& report : *reports) session.note(input_text(report));
  session.result(config::dump_fleet(jobs::with_findings(fleet, *reports), ""));
  return kExitDone;
}

Status MapCommand::check_words(bool json) const {
  if (map_.threads < 0 || map_.threads > 1024) {
    return fail(ErrorCode::kUsage, "--threads", fmt::format("{} is not 0 to 1024", map_.threads));
  }
  if (dry_run_ && json) {
    return fail(ErrorCode::kUsage, "--dry-run", "its settings are printed as YAML",
                "Leave --json out.");
  }
  std::error_code error;
  if (!truth_.empty() && !std::filesystem::exists(truth_, error)) {
    return fail(ErrorCode::kUsage, truth_, "there is no such truth",
                "Give --truth a folder with <vehicle>.tum.");
  }
  return {};
}

/// Compares with the ground truth. @return a line for the summary; nothing if the comparison is
/// impossible, which is no error of the map.
std::optional<std::string> MapCommand::judge(Session& session) const {
  if (truth_.empty()) return "";
  jobs::EvaluateJob job;
  job.input = map_.out_dir;
  job.truth = truth_;
  job.threads = map_.threads;
  const Result<assess::Evaluation> evaluation = jobs::run_evaluation(job);
  if (!evaluation) {
    session.error(evaluation.error().message());
    return std::nullopt;
  }
  for (const std::string& warning : evaluation->warnings) session.warning(printable(warning) + '.');
  return jobs::evaluation_line(*evaluation) + '\n';
}

Result<int> MapCommand::run(Session& session) {
  const Result<std::vector<Requirement>> requirements = parse_requirements(requirements_);
  if (!requirements) return tl::make_unexpected(requirements.error());
  if (Status status = read_formats(); !status) return tl::make_unexpected(status.error());
  if (Status status = check_words(session.options.json); !status) {
    return tl::make_unexpected(status.error());
  }
  map_.mcap = !no_mcap_;
  map_.keyframes = !no_keyframes_;
  map_.command_line = session.command_line;
  const Result<jobs::MapInputs> loaded = load_with_shortcuts();
  if (!loaded) return tl::make_unexpected(loaded.error());
  const config::FleetConfig* const fleet = &loaded->fleet;
  map_.facts = loaded->facts;
  const Result<drive::MapJob> job = jobs::make_map_job(*fleet, map_);
  if (!job) return tl::make_unexpected(job.error());
  if (Status status = jobs::check_recordings(*fleet); !status) {
    return tl::make_unexpected(status.error());
  }
  warn_fleet(*fleet, session);
  if (dry_run_) return plan(*fleet, *job, session);

  ProgressView view(session);
  session.run_log = map_.out_dir + "/run.log";
  const Result<drive::MapSummary> summary = drive::run_map(*job, view, stop_requested());
  session.written_run = map_.out_dir;
  session.live_line("");
  if (!summary) return tl::make_unexpected(summary.error());
  const std::optional<std::string> judgement = judge(session);
  if (!no_report_) {
    if (Status s = jobs::add_report(map_.out_dir); !s) {
      drive::mark_failed(map_.out_dir, "error: " + s.error().message());
      return tl::make_unexpected(s.error());
    }
  }
  for (const drive::VehicleSummary& vehicle : summary->vehicles) {
    session.note(input_text(vehicle.input));
  }
  for (const Finding& finding : summary->findings) {
    if (finding.id == "state.left_out") session.note(printable(finding_line(finding)));
  }
  const std::string page = map_.out_dir + (no_report_ ? "" : "/report.html");
  session.result(session.options.json ? summary->metrics_json
                                      : summary_text(*summary, page) + judgement.value_or(""));
  const int code = exit_code_of(*summary, stop_signal());
  const std::vector<std::string> broken = broken_requirements(*requirements, *summary);
  for (const std::string& sentence : broken) session.error(sentence + '.');
  session.run_log.clear();  // subsequent steps of a demo do not belong to this run
  session.written_run.clear();
  const bool as_asked = broken.empty() && judgement;
  return as_asked || code >= kExitMachine ? code : kExitBelowAsked;
}

}  // namespace

std::unique_ptr<Command> make_map_command() { return std::make_unique<MapCommand>(); }

}  // namespace rali::cli
