#include "rali/cli/live_demo.hpp"

#include <chrono>
#include <filesystem>
#include <optional>
#include <thread>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "rali/cli/child_process.hpp"
#include "rali/view/view_client.hpp"

namespace rali::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::milliseconds kNap{500};
constexpr double kEnd_s = 30.0;
constexpr std::size_t kLogLines = 5;

/// The mission part of a vehicle's /state; empty: none yet.
std::optional<nlohmann::json> mission_of(int port) {
  const auto reply = view::ask_view({"127.0.0.1", static_cast<std::uint16_t>(port), ""}, "/state");
  if (!reply || reply->status != 200) return std::nullopt;
  const auto state = nlohmann::json::parse(reply->body, nullptr, false);
  if (!state.is_object() || !state.contains("mission")) return std::nullopt;
  return state["mission"];
}

class Demo {
 public:
  Demo(const LiveDemo& demo, Session& session) : demo_(demo), session_(session) {}

  Result<bool> run();

 private:
  Status start_world();
  Status start_vehicles();
  [[nodiscard]] Status check(ChildProcess& child) const;
  Result<bool> watch();
  void end();

  [[nodiscard]] std::string path(const std::string& name) const {
    return demo_.folder + '/' + name;
  }

  const LiveDemo& demo_;
  Session& session_;
  std::optional<ChildProcess> world_;
  std::vector<ChildProcess> vehicles_;
  std::string reported_;
};

/// If a process has ended by itself, returns the reason.
Status Demo::check(ChildProcess& child) const {
  const std::optional<int> code = child.ended();
  if (!code || *code == 0 || stop_requested()) return {};
  return fail(ErrorCode::kMachine, child.log(),
              fmt::format("ended with {}: {}", *code, last_lines(child.log(), kLogLines)));
}

Status Demo::start_world() {
  std::error_code error;
  // Facts of another world would be mistaken for facts of this one.
  if (fs::exists(path("recording/simulation.json"))) fs::remove_all(path("state"), error);
  fs::create_directories(path("state"), error);
  if (error) return fail(ErrorCode::kMachine, demo_.folder, error.message());
  auto world = ChildProcess::start(
      {"simulate", demo_.scene, "--live", "-o", path("recording"), "--seed", demo_.seed,
       "--vehicles", std::to_string(demo_.vehicles), "--duration", demo_.duration_s, "--overwrite"},
      path("world.log"));
  if (!world) return tl::make_unexpected(world.error());
  world_.emplace(std::move(*world));
  // The file of an earlier demo is removed before the new one is written.
  while (!stop_requested() && last_lines(path("world.log"), 1).empty()) {
    if (Status s = check(*world_); !s) return s;
    std::this_thread::sleep_for(kNap);
  }
  return {};
}

Status Demo::start_vehicles() {
  for (int v = 1; v <= demo_.vehicles && !stop_requested(); ++v) {
    const std::string name = fmt::format("v{}", v);
    const int port = demo_.port + v - 1;
    auto vehicle = ChildProcess::start(
        {"run", path("recording/live.yaml"), "--vehicle", name, "--state", path("state/" + name),
         "--poses", path("mission"), "--view", std::to_string(port)},
        path(name + ".log"));
    if (!vehicle) return tl::make_unexpected(vehicle.error());
    vehicles_.push_back(std::move(*vehicle));
    session_.note(fmt::format("{}: http://127.0.0.1:{}", name, port));
  }
  return {};
}

Result<bool> Demo::watch() {
  while (!stop_requested()) {
    std::this_thread::sleep_for(kNap);
    if (Status s = check(*world_); !s) return tl::make_unexpected(s.error());
    if (world_->ended()) return true;
    for (ChildProcess& vehicle : vehicles_) {
      if (Status s = check(vehicle); !s) return tl::make_unexpected(s.error());
    }
    const auto mission = mission_of(demo_.port);
    if (!mission) continue;
    const std::string now = mission->value("state", std::string());
    if (now != reported_) session_.note(printable(now));
    reported_ = now;
    if (mission->value("finished", false)) return true;
  }
  return false;
}

/// Stops the world first, which closes the recording; the vehicles then process all received data.
void Demo::end() {
  if (world_) {
    world_->ask_to_end();
    world_->wait(kEnd_s);
  }
  for (const ChildProcess& vehicle : vehicles_) vehicle.ask_to_end();
  for (ChildProcess& vehicle : vehicles_) vehicle.wait(kEnd_s);
}

Result<bool> Demo::run() {
  Status started = start_world();
  if (started) started = start_vehicles();
  Result<bool> whole = started ? watch() : tl::make_unexpected(started.error());
  end();
  return whole;
}

}  // namespace

Result<bool> run_live_demo(const LiveDemo& demo, Session& session) {
  return Demo(demo, session).run();
}

}  // namespace rali::cli
