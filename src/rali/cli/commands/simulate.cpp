#include "rali/cli/commands/simulate.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "rali/cli/closed_loop_job.hpp"
#include "rali/cli/live_world_job.hpp"
#include "rali/cli/progress_view.hpp"
#include "rali/config/apply.hpp"
#include "rali/config/suggest.hpp"
#include "rali/drive/tbb_executor.hpp"
#include "rali/io/files/text.hpp"
#include "rali/scenario/recording/write_recording.hpp"
#include "rali/scenario/scene/old_scene_keys.hpp"
#include "rali/scenario/scene/scene_fields.hpp"

namespace rali::cli {
namespace {

using scenario::RecordingSummary;
using scenario::SceneSetup;

constexpr double kShippedDuration_s = 120.0;
constexpr double kMissionLimit_s = 3600.0;

bool is_yaml(const std::string& input) {
  return input.ends_with(".yaml") || input.ends_with(".yml");
}

class SimulateCommand final : public Command {
 public:
  [[nodiscard]] std::string name() const override { return "simulate"; }

  [[nodiscard]] std::string summary() const override {
    return "simulate the recordings of a fleet, with exact truth";
  }

  [[nodiscard]] std::vector<std::string> examples() const override {
    return {"rali simulate corridor -o sim",
            "rali simulate scene.yaml -o sim --fault gap:v1@30-35 --format bag"};
  }

  [[nodiscard]] std::string exit_codes() const override {
    return "0 done, 1 --closed-loop: the time limit ended it, 2 not started, 4 disk or memory, 130 "
           "interrupted (whole up to there)";
  }

  [[nodiscard]] bool json() const override { return true; }

  [[nodiscard]] Positional positional() override {
    return {"SCENE", "loop corridor floor tunnel mine ...; or a scene.yaml", &inputs_, 1, 1, {}};
  }

  [[nodiscard]] std::vector<Option> options() override;
  [[nodiscard]] Result<int> run(Session& session) override;

 private:
  [[nodiscard]] std::vector<Option> live_options();
  [[nodiscard]] Status check(Session& session) const;
  [[nodiscard]] Result<SceneSetup> setup() const;
  [[nodiscard]] Status apply_counts(SceneSetup& setup) const;
  [[nodiscard]] Status apply_options(SceneSetup& setup, bool shipped) const;
  [[nodiscard]] Status assign(SceneSetup& setup) const;
  [[nodiscard]] std::vector<std::string> mission_settings() const;
  [[nodiscard]] Result<RecordingSummary> record(const SceneSetup& setup, Session& session);
  [[nodiscard]] std::string text(const RecordingSummary& summary) const;

  std::vector<std::string> inputs_, faults_, assignments_;
  std::string folder_, lidar_, format_ = "mcap", interface_ = "lo";
  std::string seed_, vehicles_, pedestrians_, duration_s_;  ///< numbers; empty: not given
  int threads_ = 0;
  double rate_ = 1.0;
  int domain_ = 0;
  bool closed_loop_ = false, live_ = false, overwrite_ = false, no_priors_ = false;
  std::optional<drive::MissionLog> mission_;  ///< of a closed loop
};

std::vector<Option> SimulateCommand::options() {
  std::vector<Option> all = {
      {"-o,--out", "DIR", "where the recording goes", &folder_, false, {}},
      {"--seed", "N", "another place, motion and noise (default 1)", &seed_, false, {}},
      {"--vehicles", "N", "1 to 10; default: what the scene is made for", &vehicles_, false, {}},
      {"--duration",
       "S",
       "of the data (default 120); 0: all rounds to their end; --closed-loop, --live: the limit, "
       "default 3600",
       &duration_s_,
       false,
       {}},
      {"--lidar",
       "NAME",
       "of all vehicles (default rs16)",
       &lidar_,
       false,
       {sim::kLidarNames.begin(), sim::kLidarNames.end()}},
      {"--format",
       "NAME",
       "of the recordings",
       &format_,
       false,
       {scenario::kRecordingFormatNames.begin(), scenario::kRecordingFormatNames.end()}},
      {"--pedestrians", "N", "who walk about", &pedestrians_, false, {}},
      {"--fault",
       "KIND:VEHICLE@T0-T1",
       "what goes wrong, with --closed-loop and --live for the vehicles, too; repeatable. drop gap "
       "clock_jump nan cover time_field imu_scale imu_saturate uwb_bias uwb_off radio_loss (not "
       "--live) cut_file (of the recording)",
       &faults_,
       false,
       {}},
      {"--no-priors", "", "fleet.yaml has no start poses of the vehicles", &no_priors_, false, {}},
      {"--closed-loop",
       "",
       "the fleet's software drives, from unknown to mapped",
       &closed_loop_,
       false,
       {}},
      {"--set",
       "KEY=VALUE",
       "any key of scene.yaml; repeatable. With --closed-loop also settings.* of fleet.yaml, "
       "link.* "
       "of the radio between vehicles and sim.cpu_factor",
       &assignments_,
       false,
       {}},
      {"--threads", "N", "0: one per core; results do not depend on it", &threads_, true, {}},
      {"--overwrite", "", "replace what rali simulate wrote into DIR", &overwrite_, false, {}},
  };
  for (Option& option : live_options()) all.push_back(std::move(option));
  return all;
}

std::vector<Option> SimulateCommand::live_options() {
  return {
      {"--live",
       "",
       "in real time, sensors as ROS 2 topics; `rali run` of each vehicle drives it",
       &live_,
       false,
       {}},
      {"--rate", "X", "--live: times real time (default 1)", &rate_, true, {}},
      {"--domain", "N", "--live: ROS_DOMAIN_ID (default 0)", &domain_, true, {}},
      {"--interface",
       "NAME",
       "--live: network, by name or address (default lo, this machine alone)",
       &interface_,
       true,
       {}},
  };
}

/// A whole number of the command line.
Result<std::int64_t> whole_number(const char* option, const std::string& text, std::int64_t min,
                                  std::int64_t max) {
  const std::optional<std::int64_t> value = io::parse_integer(text);
  if (value && *value >= min && *value <= max) return *value;
  return fail(
      ErrorCode::kUsage, "rali simulate",
      fmt::format("{} {} is not a whole number from {} to {}", option, io::quoted(text), min, max));
}

Status SimulateCommand::check(Session& session) const {
  const auto wrong = [](std::string what, std::string remedy = {}) {
    return fail(ErrorCode::kUsage, "rali simulate", std::move(what), std::move(remedy));
  };
  if (folder_.empty()) return wrong("-o DIR is missing", "Say where the recording goes.");
  if (closed_loop_) {
    const auto notices = check_mission_settings(mission_settings());
    if (!notices) return tl::make_unexpected(notices.error());
    for (const std::string& notice : *notices) session.warning(printable(notice) + '.');
  }
  if (live_ && closed_loop_) return wrong("--live and --closed-loop exclude each other");
  if (!(rate_ >= 0.01 && rate_ <= 100.0)) return wrong("--rate is not 0.01 to 100");
  if (domain_ < 0 || domain_ > 232) return wrong("--domain is not 0 to 232");
  if (threads_ < 0 || threads_ > 1024) {
    return wrong(fmt::format("--threads {} is not 0 to 1024", threads_));
  }
  return {};
}

Status SimulateCommand::apply_counts(SceneSetup& setup) const {
  sim::FleetOptions& fleet = setup.fleet;
  if (!seed_.empty()) {
    const auto seed = whole_number("--seed", seed_, 0, std::numeric_limits<std::int64_t>::max());
    if (!seed) return tl::make_unexpected(seed.error());
    fleet.vehicle.seed = static_cast<std::uint64_t>(*seed);
  }
  if (!pedestrians_.empty()) {
    const auto people = whole_number("--pedestrians", pedestrians_, 0, 1000);
    if (!people) return tl::make_unexpected(people.error());
    fleet.vehicle.pedestrians = static_cast<int>(*people);
  }
  if (vehicles_.empty()) return {};
  const auto vehicles = whole_number("--vehicles", vehicles_, 1, sim::kVehiclesMax);
  if (!vehicles) return tl::make_unexpected(vehicles.error());
  if (!setup.vehicles.empty() && *vehicles != fleet.vehicles) {
    return fail(
        ErrorCode::kUsage, inputs_.front(),
        fmt::format("places {} vehicles, --vehicles asks for {}", fleet.vehicles, *vehicles),
        "Leave --vehicles out.");
  }
  fleet.vehicles = static_cast<int>(*vehicles);
  return {};
}

Status SimulateCommand::apply_options(SceneSetup& setup, bool shipped) const {
  sim::FleetOptions& fleet = setup.fleet;
  if (shipped) {
    fleet.vehicle.duration_s = kShippedDuration_s;
    fleet.vehicle.imu_apart = true;  // as on real vehicles
  }
  if (Status s = apply_counts(setup); !s) return s;
  if (!lidar_.empty()) {
    const Result<sim::Lidar> lidar = sim::lidar_of(lidar_);
    if (!lidar) return tl::make_unexpected(lidar.error());
    fleet.vehicle.lidar = *lidar;
  }
  if (duration_s_.empty()) return {};
  const std::optional<double> duration = io::parse_number(duration_s_);
  if (!duration || !(*duration >= 0.0 && *duration <= 36000.0)) {
    return fail(ErrorCode::kUsage, "rali simulate",
                fmt::format("--duration {} is not 0 to 36000", io::quoted(duration_s_)));
  }
  fleet.vehicle.duration_s = *duration;
  return {};
}

std::vector<std::string> SimulateCommand::mission_settings() const {
  std::vector<std::string> settings;
  std::copy_if(assignments_.begin(), assignments_.end(), std::back_inserter(settings),
               is_mission_key);
  return settings;
}

Status SimulateCommand::assign(SceneSetup& setup) const {
  config::Origins origins;
  for (const std::string& assignment : assignments_) {
    if (closed_loop_ && is_mission_key(assignment)) continue;
    const Result<config::Node> given = config::parse_assignment(assignment);
    if (!given) return tl::make_unexpected(given.error());
    const config::Node map = scenario::with_current_scene_keys(*given, setup.notices);
    const config::FieldList fields = scenario::scene_fields(setup, ".");
    if (Status s = config::apply_map(map, "", "command line", fields, origins); !s) return s;
  }
  return {};
}

Result<SceneSetup> SimulateCommand::setup() const {
  const std::string& input = inputs_.front();
  const bool shipped = !is_yaml(input);
  Result<SceneSetup> setup = SceneSetup{};
  if (shipped) {
    const Result<sim::Scene> scene = sim::scene_of(input);
    if (!scene) return tl::make_unexpected(scene.error());
    setup = scenario::shipped_scene(*scene, 1);
  } else {
    setup = scenario::load_scene(input);
  }
  if (!setup) return setup;
  if (Status s = apply_options(*setup, shipped); !s) return tl::make_unexpected(s.error());
  if (Status s = assign(*setup); !s) return tl::make_unexpected(s.error());
  return setup;
}

Result<RecordingSummary> SimulateCommand::record(const SceneSetup& setup, Session& session) {
  sim::FleetOptions fleet = setup.fleet;
  if (closed_loop_ || live_) fleet.scripted = false;
  const auto faults = scenario::parse_faults(faults_, fleet.vehicles);
  if (!faults) return tl::make_unexpected(faults.error());
  const bool cuts_link = std::any_of(faults->begin(), faults->end(), [](const auto& fault) {
    return fault.kind == scenario::FaultKind::kRadioLoss;
  });
  if (live_ && cuts_link) {
    return fail(ErrorCode::kUsage, "--fault radio_loss", "cannot cut a real network (--live)",
                "Unplug it, or use --closed-loop.");
  }
  Result<sim::World> world = scenario::world_of(setup);
  if (!world) return tl::make_unexpected(world.error());
  auto sim = sim::make_fleet_simulation(std::move(*world), fleet);
  if (!sim) return tl::make_unexpected(sim.error());
  if (Status s = scenario::prepare_recording_folder(folder_, overwrite_); !s) {
    return tl::make_unexpected(s.error());
  }
  const std::unique_ptr<Executor> executor = drive::make_executor(threads_);
  (*sim)->use(*executor);
  scenario::RecordingOptions options;
  options.folder = folder_;
  const auto format = std::find(scenario::kRecordingFormatNames.begin(),
                                scenario::kRecordingFormatNames.end(), format_);
  options.format =
      static_cast<scenario::RecordingFormat>(format - scenario::kRecordingFormatNames.begin());
  options.lidar = fleet.vehicle.lidar;
  options.with_imu = fleet.vehicle.with_imu;
  options.seed = fleet.vehicle.seed;
  options.faults = *faults;
  options.priors = !no_priors_;
  options.scene_yaml = scenario::dump_scene(setup, folder_);
  options.title = std::filesystem::path(inputs_.front()).filename().string();
  if (closed_loop_) {
    const double limit_s = io::parse_number(duration_s_).value_or(0.0);
    auto run = run_closed_loop_job(**sim, options, mission_settings(),
                                   limit_s > 0.0 ? limit_s : kMissionLimit_s, *executor, session);
    if (!run) return tl::make_unexpected(run.error());
    mission_ = std::move(run->mission);
    return std::move(run->recording);
  }
  if (live_) {
    const double limit_s = io::parse_number(duration_s_).value_or(0.0);
    const LiveWorldJob job{rate_, limit_s > 0.0 ? limit_s : kMissionLimit_s, domain_, interface_};
    return run_live_world_job(**sim, options, job, session);
  }
  ProgressView view(session);
  drive::Progress progress;
  progress.vehicle = fleet.vehicles == 1 ? "v1" : fmt::format("{} vehicles", fleet.vehicles);
  progress.stage = "simulation";
  return scenario::write_recording(**sim, options, [&](double fraction) {
    progress.fraction = fraction;
    view.progress(progress);
    return !stop_requested();
  });
}

std::string SimulateCommand::text(const RecordingSummary& s) const {
  std::string text = fmt::format("{}/fleet.yaml\n", folder_);
  text += fmt::format("{}, seed {}: {} vehicle{}, {:.1f} s of data{}\n", s.title, s.seed,
                      s.vehicles.size(), s.vehicles.size() == 1 ? "" : "s", s.duration_s,
                      s.interrupted ? " (interrupted)" : "");
  for (const scenario::VehicleSummary& v : s.vehicles) {
    text += fmt::format(
        "{}: {} scans, {:.1f} million points, {} inertial samples, {:.0f} m driven{}{}\n", v.file,
        v.scans, static_cast<double>(v.points) * 1e-6, v.imu_samples, v.path_m,
        v.lost == 0 ? "" : fmt::format(", {} messages lost", v.lost), v.cut ? ", cut off" : "");
  }
  if (s.vehicles.size() > 1) {
    const auto all = static_cast<double>(std::max<std::uint64_t>(1, s.ranges + s.ranges_spoilt));
    text += fmt::format("{} ranges, {:.0f} % of them not in line of sight; {} radio readings\n",
                        s.ranges, 100.0 * static_cast<double>(s.ranges_obstructed) / all,
                        s.radio_readings);
  }
  if (mission_) text += mission_text(*mission_, s.duration_s);
  for (const scenario::Fault& fault : s.faults) text += "fault: " + fault_text(fault) + '\n';
  return text + fmt::format("next: rali map {}/fleet.yaml -o {}-out\n", folder_, folder_);
}

Result<int> SimulateCommand::run(Session& session) {
  if (Status s = check(session); !s) return tl::make_unexpected(s.error());
  const Result<SceneSetup> scene = setup();
  if (!scene) return tl::make_unexpected(scene.error());
  for (const std::string& notice : scene->notices) session.warning(printable(notice) + '.');
  const Result<RecordingSummary> summary = record(*scene, session);
  session.live_line("");
  if (!summary) return tl::make_unexpected(summary.error());
  session.result(session.options.json ? scenario::summary_json(*summary) : text(*summary));
  if (summary->interrupted) return 128 + stop_signal();
  return mission_ && !mission_->ended ? kExitBelowAsked : kExitDone;
}

}  // namespace

std::unique_ptr<Command> make_simulate_command() { return std::make_unique<SimulateCommand>(); }

}  // namespace rali::cli
