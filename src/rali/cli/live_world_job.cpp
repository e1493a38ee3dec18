#include "rali/cli/live_world_job.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "rali/cli/record_mission.hpp"
#include "rali/host/world/live_world.hpp"
#include "rali/io/files/atomic_file.hpp"
#include "rali/net/dds_ros_bus.hpp"
#include "rali/net/fleet_key.hpp"
#include "rali/scenario/recording/fleet_yaml.hpp"
#include "rali/scenario/vehicle_names.hpp"

namespace rali::cli {
namespace {

using Clock = std::chrono::steady_clock;

/// Maximum delay until a signal is handled.
constexpr std::chrono::milliseconds kNap{20};

/// Couples simulated time to wall time. If the machine is too slow, the simulation slows down, so
/// that subscribers lose no data.
class Pace {
 public:
  Pace(Time t_start, double rate) : t_start_(t_start), rate_(rate) {}

  /// Waits until simulated time `now` is due. @return false: a signal asks to stop
  bool wait(Time now) {
    if (!begun_) begun_ = Clock::now();
    const double due_s = seconds_between(t_start_, now) / rate_ + lag_s_;
    while (!stop_requested()) {
      const double left_s = due_s - elapsed_s();
      if (left_s <= 0.0) {
        lag_s_ += -left_s;
        return true;
      }
      const auto left = std::chrono::duration<double>(left_s);
      std::this_thread::sleep_for(std::min<std::chrono::duration<double>>(left, kNap));
    }
    return false;
  }

  /// Delay of simulated time [s].
  [[nodiscard]] double lag_s() const { return lag_s_; }

 private:
  [[nodiscard]] double elapsed_s() const {
    return std::chrono::duration<double>(Clock::now() - *begun_).count();
  }

  Time t_start_;
  double rate_;
  std::optional<Clock::time_point> begun_;
  double lag_s_ = 0.0;
};

Status write_live_files(const sim::FleetSimulation& sim, const std::vector<std::string>& names,
                        const scenario::RecordingOptions& options, const LiveWorldJob& job) {
  scenario::LiveNetwork network;
  network.ros_domain = job.ros_domain;
  if (names.size() > 1) {
    const auto key = net::create_fleet_key(options.folder + "/" + network.key_file);
    if (!key) return tl::make_unexpected(key.error());
  }
  return io::write_file_atomic(options.folder + "/live.yaml",
                               scenario::live_fleet_yaml(sim, names, options, network));
}

/// Waits until every LiDAR has a subscriber; a signal ends the wait, too.
void wait_for_listeners(const host::LiveWorld& world, Session& session) {
  std::vector<std::string> reported;
  while (!stop_requested()) {
    const std::vector<std::string> unsubscribed = world.unsubscribed();
    if (unsubscribed.empty()) return;
    if (unsubscribed != reported) {
      session.note(fmt::format("waiting for `rali run` of {}", fmt::join(unsubscribed, ", ")));
      reported = unsubscribed;
    }
    std::this_thread::sleep_for(kNap);
  }
}

}  // namespace

Result<scenario::RecordingSummary> run_live_world_job(sim::FleetSimulation& sim,
                                                      const scenario::RecordingOptions& options,
                                                      const LiveWorldJob& job, Session& session) {
  const std::vector<std::string> names = scenario::vehicle_names(sim.vehicles());
  if (Status s = write_live_files(sim, names, options, job); !s) {
    return tl::make_unexpected(s.error());
  }
  net::RosBusOptions bus_options;
  bus_options.domain = job.ros_domain;
  bus_options.interface = job.ros_interface;
  bus_options.node_name = "rali_world";
  auto bus = net::open_dds_ros_bus(bus_options);
  if (!bus) return tl::make_unexpected(bus.error());
  Pace pace(sim.t_start(), job.rate);
  auto world = host::LiveWorld::make(**bus, {names, options.lidar},
                                     [&](Time now) { return pace.wait(now); });
  if (!world) return tl::make_unexpected(world.error());
  session.note(fmt::format("{}/live.yaml: start `rali run {}/live.yaml --vehicle {}`",
                           options.folder, options.folder, names.front()));
  wait_for_listeners(**world, session);
  auto summary = record_mission(sim, options, **world, job.time_limit_s);
  constexpr double kLagReported_s = 1.0;
  if (pace.lag_s() > kLagReported_s) {
    session.warning(
        fmt::format("this machine made the world {:.1f} s slower than asked", pace.lag_s()));
  }
  if ((*world)->counts().unreadable > 0) {
    session.warning(fmt::format("{} messages to the world were no goals, poses or transforms",
                                (*world)->counts().unreadable));
  }
  return summary;
}

}  // namespace rali::cli
