#include "rali/cli/commands/play.hpp"

#include <algorithm>
#include <chrono>
#include <thread>

#include <fmt/format.h>

#include "rali/base/counted.hpp"
#include "rali/cli/play/ranges_beside.hpp"
#include "rali/cli/play/recording_player.hpp"
#include "rali/net/dds_ros_bus.hpp"
#include "rali/net/ros_names.hpp"

namespace rali::cli {
namespace {

using std::chrono::steady_clock;

constexpr auto kLookEvery = std::chrono::milliseconds(50);
/// Time for discovery before the first message, and for delivery of the last one.
constexpr auto kSettle = std::chrono::milliseconds(500);
constexpr double kRateMax = 1000.0;

/// UTC advanced by the steady clock, independent of clock adjustments.
class SteadyWallClock {
 public:
  [[nodiscard]] Time now() const { return wall_0_ + since(steady_clock::now()); }

  /// False: the user stopped.
  [[nodiscard]] bool sleep_until(Time t) const {
    const auto end = steady_0_ + std::chrono::nanoseconds((t - wall_0_).ns);
    while (steady_clock::now() < end) {
      if (stop_requested()) return false;
      std::this_thread::sleep_until(std::min(end, steady_clock::now() + kLookEvery));
    }
    return !stop_requested();
  }

 private:
  [[nodiscard]] Duration since(steady_clock::time_point t) const {
    return Duration::from_ns(
        std::chrono::duration_cast<std::chrono::nanoseconds>(t - steady_0_).count());
  }

  steady_clock::time_point steady_0_ = steady_clock::now();
  Time wall_0_ = Time::from_ns(std::chrono::duration_cast<std::chrono::nanoseconds>(
                                   std::chrono::system_clock::now().time_since_epoch())
                                   .count());
};

class PlayCommand final : public Command {
 public:
  [[nodiscard]] std::string name() const override { return "play"; }

  [[nodiscard]] std::string summary() const override {
    return "sensors of a recording, live on a ROS 2 network";
  }

  [[nodiscard]] std::vector<std::string> examples() const override {
    return {"rali play run1.bag --wait", "rali play v1.mcap --vehicle v1 --domain 7 --restamp"};
  }

  [[nodiscard]] std::string exit_codes() const override {
    return "0 played, 2 not readable or wrong options, 3 damaged, 4 no network, 130 interrupted";
  }

  [[nodiscard]] Positional positional() override {
    return {"RECORDING", "ROS 1 bag, MCAP, rosbag2 folder or .db3", &recordings_, 1, 1, {}};
  }

  [[nodiscard]] std::vector<Option> options() override {
    return {{"--vehicle",
             "NAME",
             "put /NAME before the topics, so that fleets share a domain",
             &options_.vehicle,
             false,
             {}},
            {"--rate", "X", "times as fast as recorded, up to 1000", &options_.rate, false, {}},
            {"--domain",
             "N",
             "ROS domain, 0 to 232 (default: ROS_DOMAIN_ID, else 0)",
             &domain_,
             false,
             {}},
            {"--interface",
             "NAME",
             "network, by name or address; lo is this machine alone",
             &interface_,
             false,
             {}},
            {"--wait", "", "begin when somebody listens to LiDAR and IMU", &wait_, false, {}},
            {"--restamp",
             "",
             "stamps as if it happened now, not when it was recorded",
             &options_.restamp,
             false,
             {}},
            {"--ranges",
             "FILE",
             "CSV of ranges beside the recording: those of --vehicle are played, too",
             &ranges_,
             false,
             {}},
            {"--topic",
             "NAME",
             "only this topic, of any type; repeatable",
             &options_.topics,
             false,
             {}}};
  }

  [[nodiscard]] Result<int> run(Session& session) override {
    if (Status status = check(); !status) return tl::make_unexpected(status.error());
    auto source = io::open_recording(recordings_[0]);
    if (source && !ranges_.empty()) {
      source = with_ranges(std::move(*source), ranges_, options_.vehicle);
    }
    if (!source) return tl::make_unexpected(source.error());
    auto bus = open_bus();
    if (!bus) return tl::make_unexpected(bus.error());
    const SteadyWallClock clock;
    RecordingPlayer player(
        **source, **bus, options_,
        {[&] { return clock.now(); }, [&](Time t) { return clock.sleep_until(t); }});
    if (Status status = player.advertise(); !status) {
      Error error = status.error();
      error.where = recordings_[0];
      return tl::make_unexpected(std::move(error));
    }
    for (const std::string& name : player.published()) session.detail("publishes " + name);
    if (wait_ && !wait_for_readers(session, player)) return interrupted();
    const Time t_start = clock.now();
    const auto tally = player.play([&](double fraction, const PlayTally& so_far) {
      if (!session.live() || session.options.quiet) return;
      session.live_line(
          fmt::format("{:3.0f} %, {}", 100.0 * fraction, counted(so_far.messages, "message")));
    });
    const double took_s = seconds_between(t_start, clock.now());
    session.live_line("");
    if (!tally) return tl::make_unexpected(tally.error());
    std::this_thread::sleep_for(kSettle);
    return report(session, **source, player, *tally, took_s, (*bus)->counts());
  }

 private:
  [[nodiscard]] Status check() const {
    if (!(options_.rate > 0.0) || options_.rate > kRateMax) {
      return fail(ErrorCode::kUsage, "--rate", "is not above 0 and up to 1000");
    }
    if (!options_.vehicle.empty() && !net::dds_topic_name("/" + options_.vehicle)) {
      return fail(ErrorCode::kUsage, "--vehicle", "is no name that ROS allows",
                  "Use letters, digits and underscores, a letter first.");
    }
    return {};
  }

  [[nodiscard]] Result<std::unique_ptr<net::RosBus>> open_bus() const {
    net::RosBusOptions options;
    const auto domain = domain_.empty() ? net::ros_domain_of_environment()
                                        : net::parse_ros_domain(domain_, "--domain");
    if (!domain) return tl::make_unexpected(domain.error());
    options.domain = *domain;
    options.interface = interface_;
    options.node_name = "rali_play";
    if (!options_.vehicle.empty()) options.node_namespace = "/" + options_.vehicle;
    return net::open_dds_ros_bus(options);
  }

  /// False: the user stopped the waiting.
  [[nodiscard]] bool wait_for_readers(Session& session, const RecordingPlayer& player) const {
    if (player.published().empty()) {
      session.warning(recordings_[0] + ": has no index, so --wait waits for nobody");
      return true;
    }
    session.note("waiting for readers of LiDAR and IMU");
    while (!player.is_received()) {
      if (stop_requested()) return false;
      std::this_thread::sleep_for(kLookEvery);
    }
    std::this_thread::sleep_for(kSettle);
    return true;
  }

  [[nodiscard]] tl::unexpected<Error> interrupted() const {
    return fail(ErrorCode::kInterrupted, recordings_[0], "stopped");
  }

  [[nodiscard]] Result<int> report(Session& session, const io::MessageSource& source,
                                   const RecordingPlayer& player, const PlayTally& tally,
                                   double took_s, const net::RosCounts& sent) const {
    for (const Finding& finding : source.health().findings) session.warning(finding.text);
    for (const std::string& sentence : player.left_out()) session.note("not played: " + sentence);
    if (tally.damaged > 0) {
      session.warning(counted(tally.damaged, "message") + " shorter than their types: left out");
    }
    if (sent.refused > 0) {
      session.warning(counted(sent.refused, "message") +
                      " not sent: a reliable reader is too slow");
    }
    session.result(fmt::format("{}: {} of {} in {:.1f} s, at most {:.0f} ms late\n", recordings_[0],
                               counted(tally.messages, "message"),
                               counted(player.published().size(), "topic"), took_s,
                               1e3 * tally.latest.s()));
    if (tally.stopped) return interrupted();
    const bool has_gaps =
        source.health().truncated || source.health().messages_skipped > 0 || tally.damaged > 0;
    return has_gaps ? kExitGaps : kExitDone;
  }

  std::vector<std::string> recordings_;
  PlayOptions options_;
  std::string domain_, interface_ = "lo", ranges_;
  bool wait_ = false;
};

}  // namespace

std::unique_ptr<Command> make_play_command() { return std::make_unique<PlayCommand>(); }

}  // namespace rali::cli
