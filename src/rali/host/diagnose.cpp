#include <algorithm>

#include <fmt/format.h>

#include "rali/host/fleet_state.hpp"
#include "rali/host/mode_words.hpp"

namespace rali::host {
namespace {

using Level = DiagnosticLevel;

/// A sensor is late after this many of its periods, and at least after this time.
constexpr double kLatePeriods = 5.0, kLate_s = 0.5, kGone_s = 3.0;
/// Beyond this latency the pose is not usable for driving.
constexpr double kLatency_s = 0.1;
constexpr double kPeerGone_s = 3.0, kFindingShown_s = 60.0;

DiagnosticLine sensor_line(const SensorHealth& sensor, HostTime now) {
  DiagnosticLine line;
  line.name = "sensors/" + sensor.name;
  if (!sensor.t_last) {
    line.level = Level::kStale;
    line.message = fmt::format("No message on {} yet.", sensor.topic);
    return line;
  }
  line.age_s = seconds_between(*sensor.t_last, now.wall);
  const double period_s = sensor.rate_hz > 0.0 ? 1.0 / sensor.rate_hz : 0.0;
  const bool late = *line.age_s > std::max(kLate_s, kLatePeriods * period_s);
  if (*line.age_s > kGone_s) {
    line.level = Level::kStale;
    line.message = fmt::format("No message on {} for {:.0f} s.", sensor.topic, *line.age_s);
    line.remedy = "Look at the driver, its cable and its power.";
  } else if (late) {
    line.level = Level::kWarn;
    line.message = fmt::format("No message on {} for {:.1f} s.", sensor.topic, *line.age_s);
  } else {
    line.message = fmt::format("{} at {:.1f} Hz.", sensor.topic, sensor.rate_hz);
  }
  return line;
}

DiagnosticLine input_line(const SensorNews& sensors) {
  DiagnosticLine line;
  line.name = "sensors";
  if (!sensors.decided) {
    line.level = Level::kStale;
    line.message = sensors.waits_for.empty() ? "waits for sensors." : sensors.waits_for;
    return line;
  }
  const LiveOrderTally& order = sensors.order;
  if (order.dropped_scans + order.late_scans + sensors.gaps.undecodable > 0) {
    line.level = Level::kWarn;
    line.message = fmt::format("{} scans dropped, {} late, {} messages damaged since the start.",
                               order.dropped_scans, order.late_scans, sensors.gaps.undecodable);
    line.remedy =
        "Dropped scans: this computer is too slow or too busy. Damaged: look at the driver.";
  } else {
    line.message = "All messages are used.";
  }
  return line;
}

DiagnosticLine odometry_line(const FleetSide& side, HostTime now) {
  DiagnosticLine line;
  line.name = "odometry";
  const auto& pose = side.agent()->pose();
  if (!pose) {
    line.level = Level::kStale;
    line.message = "No pose yet.";
    return line;
  }
  line.age_s = std::max(0.0, seconds_between(pose->t, side.agent_time(now)));
  const double latency_s = side.sensors().latency_p99_s;
  if (pose->quality == vehicle::PoseQuality::kDiverged) {
    line.level = Level::kError;
    line.message = "The pose is lost: scans do not fit the map.";
    line.remedy = "Stop, and drive back to where the map is good.";
  } else if (*line.age_s > kGone_s) {
    line.level = Level::kStale;
    line.message = fmt::format("No pose for {:.0f} s.", *line.age_s);
  } else if (pose->seeks_gravity) {
    line.level = Level::kWarn;
    line.message = "The direction of gravity is not known yet.";
    line.remedy = "Let the vehicle stand still for some seconds.";
  } else if (latency_s > kLatency_s) {
    line.level = Level::kWarn;
    line.message = fmt::format("Poses come {:.0f} ms after their scans (99 %).", 1e3 * latency_s);
    line.remedy = "Give the program more of the computer.";
  } else {
    line.message = pose->quality == vehicle::PoseQuality::kGood ? "Scans are registered."
                                                                : "Scans are registered weakly.";
  }
  return line;
}

DiagnosticLine degeneracy_line(const FleetSide& side, HostTime now) {
  DiagnosticLine line;
  line.name = "degeneracy";
  line.message = "The LiDAR sees all directions.";
  if (const auto since = side.degenerate_since()) {
    line.level = Level::kWarn;
    line.age_s = seconds_between(*since, now.boot);
    line.message = fmt::format(
        "The LiDAR does not see one direction since {:.0f} s: ranges hold it.", *line.age_s);
  }
  return line;
}

DiagnosticLine role_line(const FleetSide& side) {
  const Agent& agent = *side.agent();
  const fleet::Mode mode = agent.node().mode();
  DiagnosticLine line;
  line.name = "fleet/role";
  const bool waits = mode == fleet::Mode::kStarting || mode == fleet::Mode::kUnplaced ||
                     mode == fleet::Mode::kOrphan || mode == fleet::Mode::kCandidate;
  line.level = waits ? Level::kWarn : Level::kOk;
  const bool has_goal = !agent.node().order().places_map_m.empty();
  line.message = fmt::format("{} {} (term {}).", side.setup().agent.names[agent.self().value],
                             waiting_words(mode, has_goal), agent.node().term());
  return line;
}

void link_lines(const FleetSide& side, const HostFacts& host, HostTime now,
                std::vector<DiagnosticLine>& lines) {
  const auto& names = side.setup().agent.names;
  const Time t = side.agent_time(now);
  for (const net::LinkCounts& link : host.links) {
    if (link.peer.value >= names.size()) continue;
    DiagnosticLine line;
    line.name = "fleet/link_" + names[link.peer.value];
    const auto received = side.agent()->received().find(link.peer);
    if (received != side.agent()->received().end())
      line.age_s = seconds_between(received->second.t, t);
    if (!line.age_s) {
      line.level = Level::kStale;
      line.message = fmt::format("No message from {} yet.", names[link.peer.value]);
      line.remedy = "Compare key, addresses and domain of both vehicles.";
    } else if (*line.age_s > kPeerGone_s) {
      line.level = Level::kWarn;
      line.message =
          fmt::format("No message from {} for {:.0f} s.", names[link.peer.value], *line.age_s);
    } else {
      line.message = fmt::format("{} is connected.", names[link.peer.value]);
    }
    if (link.forged > 0) {
      line.level = std::max(line.level, Level::kWarn);
      line.message += fmt::format(" {} messages were not signed by the fleet's key.", link.forged);
    }
    lines.push_back(std::move(line));
  }
}

DiagnosticLine disk_line(const HostFacts& host) {
  DiagnosticLine line;
  line.name = "disk";
  line.message = fmt::format("{:.1f} GB free.", static_cast<double>(host.disk->free_bytes) * 1e-9);
  if (host.disk->state == "ok") return line;
  line.level = host.disk->state == "full" ? Level::kError : Level::kWarn;
  line.message += ' ' + host.disk->message;
  line.remedy = "Free space on the disk of the state.";
  return line;
}

DiagnosticLine program_line(const HostFacts& host) {
  DiagnosticLine line;
  line.name = "program";
  line.message = fmt::format("Steps of the agent: 99 % below {:.1f} ms.", 1e3 * host.step_p99_s);
  if (host.queue_refused > 0) {
    line.level = Level::kError;
    line.message += fmt::format(" {} values did not fit into a queue.", host.queue_refused);
    line.remedy = "Give the program more of the computer.";
  }
  return line;
}

}  // namespace

std::vector<DiagnosticLine> diagnose(const FleetSide& side, const HostFacts& host, HostTime now) {
  std::vector<DiagnosticLine> lines;
  lines.push_back(input_line(side.sensors()));
  for (const SensorHealth& sensor : side.sensors().sensors) {
    if (sensor.name != "tf_static") lines.push_back(sensor_line(sensor, now));
  }
  if (side.agent() != nullptr) {
    lines.push_back(odometry_line(side, now));
    lines.push_back(degeneracy_line(side, now));
    lines.push_back(role_line(side));
    if (host.has_link) link_lines(side, host, now, lines);
  }
  if (host.disk) lines.push_back(disk_line(host));
  lines.push_back(program_line(host));
  for (const RecentFinding& recent : side.findings()) {
    const Finding& f = recent.finding;
    const double age_s = seconds_between(recent.t_boot, now.boot);
    if (f.severity == Severity::kInfo || age_s > kFindingShown_s) continue;
    const Level level = f.severity == Severity::kError ? Level::kError : Level::kWarn;
    lines.push_back({level, "finding/" + f.id, f.text, f.remedy, age_s});
  }
  return lines;
}

}  // namespace rali::host
