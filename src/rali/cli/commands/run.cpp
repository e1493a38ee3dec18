#include "rali/cli/commands/run.hpp"

#include <atomic>
#include <charconv>
#include <filesystem>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "rali/cli/live_setup.hpp"
#include "rali/cli/progress_view.hpp"
#include "rali/config/load_fleet.hpp"
#include "rali/drive/tbb_executor.hpp"
#include "rali/host/host_clock.hpp"
#include "rali/host/service_notify.hpp"
#include "rali/io/files/tum.hpp"
#include "rali/net/fleet_key.hpp"

namespace rali::cli {
namespace {

class RunCommand final : public Command {
 public:
  [[nodiscard]] std::string name() const override { return "run"; }

  [[nodiscard]] std::string summary() const override {
    return "map live: one vehicle of a fleet, sensors over ROS 2";
  }

  [[nodiscard]] std::vector<std::string> examples() const override {
    return {"rali run fleet.yaml --vehicle v1 --state /var/lib/rali/v1",
            "rali run --new-key fleet.key"};
  }

  [[nodiscard]] std::string exit_codes() const override {
    return "0 ended by --for, SIGINT or SIGTERM, 2 not started, 3 the same without any pose, 4 "
           "disk, "
           "memory or network";
  }

  [[nodiscard]] Positional positional() override {
    return {"FLEET", "fleet.yaml of the fleet, the same on all vehicles", &inputs_, 0, 1, {}};
  }

  [[nodiscard]] std::vector<Option> options() override {
    return {
        {"--vehicle", "NAME", "which vehicle of the fleet this is", &vehicle_, false, {}},
        {"--state",
         "DIR",
         "what must outlive a restart (default: rali_state/NAME)",
         &state_,
         false,
         {}},
        {"--record", "DIR", "record the sensors' messages to DIR/NAME.mcap", &record_, false, {}},
        {"--poses",
         "DIR",
         "write the poses in map as they are published to DIR/live/NAME.tum",
         &poses_,
         false,
         {}},
        {"--view", "PORT", "port of the live page, or none", &view_, false, {}},
        {"--for", "S", "end after so long [s]; 0: never", &for_s_, false, {}},
        {"--set",
         "KEY=VALUE",
         "any setting of docs/reference/settings.md; repeatable",
         &assignments_,
         false,
         {}},
        {"--threads", "N", "of the odometry; 0: one per core", &threads_, true, {}},
        {"--new-key", "FILE", "make a key for a fleet and end", &new_key_, false, {}},
    };
  }

  [[nodiscard]] Result<int> run(Session& session) override;

 private:
  [[nodiscard]] Status check_words() const;
  [[nodiscard]] Result<std::unique_ptr<view::ViewServer>> open_view(
      const config::FleetConfig& fleet, Session& session) const;
  [[nodiscard]] Result<std::optional<io::TumWriter>> open_poses(const std::string& vehicle) const;
  [[nodiscard]] Result<int> run_vehicle(const config::FleetConfig& fleet, LiveSetup setup,
                                        Session& session);

  std::vector<std::string> inputs_, assignments_;
  std::string vehicle_, state_, record_, poses_, view_, new_key_;
  double for_s_ = 0.0;
  int threads_ = 1;
};

/// Reports events, and ends the run at its time limit.
class RunListener final : public host::HostListener {
 public:
  RunListener(Session& session, double for_s, std::atomic<bool>& stop)
      : session_(session), for_s_(for_s), stop_(stop), begin_(host::host_now().boot) {}

  void finding(const Finding& finding) override {
    const std::string line = printable(finding_line(finding));
    if (finding.severity == Severity::kInfo) {
      session_.note(line);
    } else {
      session_.warning(line);
    }
  }

  void state(const host::LiveState& state) override {
    const double age_s = seconds_between(begin_, host::host_now().boot);
    if (stop_requested() || (for_s_ > 0.0 && age_s >= for_s_)) stop_ = true;
    host::notify_service(fmt::format("{}WATCHDOG=1\nSTATUS={}", std::exchange(ready_, ""),
                                     printable(state.waits_for)));
    if (state.waits_for != waits_for_) {
      waits_for_ = state.waits_for;
      session_.note(printable(waits_for_));
    }
  }

 private:
  Session& session_;
  double for_s_;
  std::atomic<bool>& stop_;
  Time begin_;
  std::string waits_for_;
  std::string ready_ = "READY=1\n";  ///< until it was sent
};

Status RunCommand::check_words() const {
  if (!(for_s_ >= 0.0)) return fail(ErrorCode::kUsage, "--for", "must not be negative");
  if (threads_ < 0 || threads_ > 1024) {
    return fail(ErrorCode::kUsage, "--threads", fmt::format("{} is not 0 to 1024", threads_));
  }
  if (inputs_.empty()) {
    return fail(ErrorCode::kUsage, "command line", "no fleet.yaml is named",
                "Write rali run fleet.yaml --vehicle NAME.");
  }
  return {};
}

Result<std::unique_ptr<view::ViewServer>> RunCommand::open_view(const config::FleetConfig& fleet,
                                                                Session& session) const {
  if (view_ == "none") return std::unique_ptr<view::ViewServer>();
  view::ViewOptions options;
  options.bind = fleet.live.view_bind;
  options.port = static_cast<std::uint16_t>(fleet.live.view_port);
  if (!view_.empty()) {
    const auto [end, error] =
        std::from_chars(view_.data(), view_.data() + view_.size(), options.port);
    if (error != std::errc{} || end != view_.data() + view_.size()) {
      return fail(ErrorCode::kUsage, "--view", fmt::format("'{}' is no port", view_),
                  "Give 0 to 65535, or none.");
    }
  }
  Result<std::string> token = read_token(fleet.live.view_token_file);
  if (!token) return tl::make_unexpected(token.error());
  options.token = std::move(*token);
  auto server = view::start_view_server(options);
  if (server) {
    session.note(fmt::format("live page: http://{}:{}", options.bind, (*server)->port()));
  }
  return server;
}

Result<std::optional<io::TumWriter>> RunCommand::open_poses(const std::string& vehicle) const {
  if (poses_.empty()) return std::optional<io::TumWriter>();
  const std::string folder = poses_ + "/live";
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    return fail(ErrorCode::kMachine, folder, "could not be made: " + error.message(),
                "Name a folder that can be written.");
  }
  auto writer = io::TumWriter::create(
      folder + '/' + vehicle + ".tum",
      {"rali run: T_map_body of " + vehicle + " as published when its scan was processed"});
  if (!writer) return tl::make_unexpected(writer.error());
  return std::optional(std::move(*writer));
}

Result<int> RunCommand::run(Session& session) {
  if (!new_key_.empty()) {
    const Result<net::FleetKey> key = net::create_fleet_key(new_key_);
    if (!key) return tl::make_unexpected(key.error());
    session.note(
        fmt::format("{}: give it to all vehicles of the fleet, and to nobody else.", new_key_));
    return kExitDone;
  }
  if (Status status = check_words(); !status) return tl::make_unexpected(status.error());
  config::Overrides overrides;
  overrides.assignments = assignments_;
  overrides.live = true;
  const Result<config::FleetConfig> fleet = config::load_fleet(inputs_.front(), overrides);
  if (!fleet) return tl::make_unexpected(fleet.error());
  for (const std::string& notice : fleet->notices) session.warning(printable(notice) + '.');
  const Result<std::size_t> index = vehicle_index(*fleet, vehicle_);
  if (!index) return tl::make_unexpected(index.error());
  Result<LiveSetup> setup = make_live_setup(*fleet, *index);
  if (!setup) return tl::make_unexpected(setup.error());
  return run_vehicle(*fleet, std::move(*setup), session);
}

Result<int> RunCommand::run_vehicle(const config::FleetConfig& fleet, LiveSetup setup,
                                    Session& session) {
  const config::VehicleConfig& vehicle = fleet.vehicles[setup.index];
  const std::string folder = state_.empty() ? "rali_state/" + vehicle.name : state_;
  Result<drive::StateDir> state =
      drive::StateDir::open(folder, setup.host.sensors.self, vehicle_ids(fleet));
  if (!state) return tl::make_unexpected(state.error());
  restore(setup, *state);
  auto bus = open_ros_bus(fleet, setup.index);
  if (!bus) return tl::make_unexpected(bus.error());
  auto link = open_fleet_link(fleet, setup.index, setup.host.fleet.agent.start, state->seen());
  if (!link) return tl::make_unexpected(link.error());
  auto view = open_view(fleet, session);
  if (!view) return tl::make_unexpected(view.error());
  std::unique_ptr<host::RecordWriter> record;
  if (!record_.empty()) {
    auto made = host::RecordWriter::create(record_, vehicle.name);
    if (!made) return tl::make_unexpected(made.error());
    record = std::move(*made);
  }
  auto poses = open_poses(vehicle.name);
  if (!poses) return tl::make_unexpected(poses.error());
  std::optional<net::SerialPort> serial;
  if (!vehicle.live.serial_port.empty()) {
    auto port = net::SerialPort::open(vehicle.live.serial_port, vehicle.live.serial_baud);
    if (!port) return tl::make_unexpected(port.error());
    serial = std::move(*port);
  }
  const std::unique_ptr<Executor> executor = drive::make_executor(threads_);
  host::LiveHost host(std::move(setup.host),
                      {bus->get(), link->get(), view->get(), &*state, record.get(),
                       *poses ? &**poses : nullptr, serial ? &*serial : nullptr},
                      *executor);
  std::atomic<bool> stop{false};
  RunListener listener(session, for_s_, stop);
  const host::LiveHostEnd end = host.run(listener, stop);
  if (!end.status) return tl::make_unexpected(end.status.error());
  session.note(fmt::format(
      "{} poses, {:.1f} m; latency of a pose {:.1f} ms (median), {:.1f} ms (99 %)", end.scans,
      end.last.distance_m, 1e3 * end.last.latency_p50_s, 1e3 * end.last.latency_p99_s));
  return end.scans > 0 ? kExitDone : kExitGaps;
}

}  // namespace

std::unique_ptr<Command> make_run_command() { return std::make_unique<RunCommand>(); }

}  // namespace rali::cli
