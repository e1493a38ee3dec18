#include "rali/cli/map_summary.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "rali/base/counted.hpp"
#include "rali/base/heading.hpp"
#include "rali/cli/command.hpp"
#include "rali/config/extrinsics.hpp"
#include "rali/config/suggest.hpp"
#include "rali/config/yaml_tree.hpp"

namespace rali::cli {
namespace {

using drive::MapSummary;
using drive::VehicleSummary;

std::string joined(const MapSummary& summary, std::string_view separator,
                   std::string (*text)(const VehicleSummary&)) {
  std::vector<std::string> parts;
  for (const VehicleSummary& vehicle : summary.vehicles) parts.push_back(text(vehicle));
  return fmt::format("{}", fmt::join(parts, separator));
}

bool has_pose(const VehicleSummary& vehicle) { return std::isfinite(vehicle.sigma_max_m); }

/// "2 vehicles in one frame (v2 placed by the prior, sigma 0.04 m, 0.2 deg)".
std::string vehicles_line(const MapSummary& summary) {
  if (summary.vehicles.size() == 1) return "1 vehicle";
  const fleet::FleetEstimate& fleet = summary.fleet;
  std::vector<std::string> placed;
  for (const fleet::VehicleFrame& frame : fleet.frames) {
    if (!frame.decided_by) continue;
    const std::string heading =
        heading_is_known(frame.sigma_rad)
            ? fmt::format("{:.1f} deg", frame.sigma_rad * 180.0 / std::numbers::pi)
            : "heading unknown";
    placed.push_back(fmt::format("{} placed by {}, sigma {:.2f} m, {}",
                                 summary.vehicles[frame.vehicle.value].name,
                                 decided_by_text(*frame.decided_by), frame.sigma_m, heading));
  }
  std::string line = fmt::format("{} vehicles", summary.vehicles.size());
  if (fleet.groups.size() == 1) line += " in one frame";
  if (fleet.groups.size() == summary.vehicles.size()) {
    line += ", each in a frame of its own";
  } else if (fleet.groups.size() > 1) {
    line += fmt::format(" in {} frames", fleet.groups.size());
  }
  return placed.empty() ? line : fmt::format("{} ({})", line, fmt::join(placed, "; "));
}

/// ", 3 loops closed, 1 refused"; nothing without candidates.
std::string loops_words(const MapSummary& summary) {
  const auto& loops = summary.fleet.loops;
  const auto closed = static_cast<std::size_t>(std::count_if(
      loops.begin(), loops.end(), [](const fleet::LoopVerdict& l) { return l.accepted; }));
  std::string text;
  if (closed > 0) text += fmt::format(", {} closed", counted(closed, "loop"));
  if (loops.size() > closed) text += fmt::format(", {} refused", loops.size() - closed);
  return text;
}

/// "3 rounds, anchors v1 v2 v1"; nothing without rounds.
std::string rounds_line(const MapSummary& summary) {
  constexpr std::size_t kAnchorsMax = 12;
  if (summary.rounds.empty()) return {};
  std::vector<std::string> anchors;
  for (const fleet::RoundRow& round : summary.rounds) {
    if (anchors.size() == kAnchorsMax) {
      anchors.emplace_back("...");
      break;
    }
    anchors.push_back(summary.vehicles[round.anchor.value].name);
  }
  return fmt::format("{}, {} {}\n", counted(summary.rounds.size(), "round"),
                     anchors.size() == 1 ? "anchor" : "anchors", fmt::join(anchors, " "));
}

/// Nothing if no vehicle has a pose.
std::string sigma_line(const MapSummary& summary) {
  const VehicleSummary* worst = nullptr;
  double median_m = 0.0;
  for (const VehicleSummary& vehicle : summary.vehicles) {
    if (!has_pose(vehicle)) continue;
    median_m = std::max(median_m, vehicle.sigma_median_m);
    if (worst == nullptr || vehicle.sigma_max_m > worst->sigma_max_m) worst = &vehicle;
  }
  if (worst == nullptr) return {};
  const double at_s = seconds_between(worst->input.t_start, worst->t_sigma_max);
  return fmt::format(
      "expected position error (1 sigma): median {:.2f} m, worst {:.2f} m ({}, {:.0f} s)\n",
      median_m, worst->sigma_max_m, worst->name, at_s);
}

/// "degenerate: v1 8 %, v2 27 % of the distance travelled; constrained by ranges 94 % of it".
/// Nothing if no vehicle has a pose.
std::string degenerate_line(const MapSummary& summary) {
  std::vector<std::string> fractions;
  for (const VehicleSummary& v : summary.vehicles) {
    if (!has_pose(v)) continue;
    fractions.push_back(fmt::format("{} {:.0f} %", v.name, 100.0 * v.degenerate_fraction));
  }
  if (fractions.empty()) return {};
  std::string line =
      fmt::format("degenerate: {} of the distance travelled", fmt::join(fractions, ", "));
  double degenerate_m = 0.0, constrained_m = 0.0;
  for (const VehicleSummary& v : summary.vehicles) {
    degenerate_m += v.degenerate_fraction * v.path_m;
    constrained_m += v.degenerate_held_fraction * v.degenerate_fraction * v.path_m;
  }
  if (summary.ranges.total > 0 && degenerate_m > 0.0) {
    line +=
        fmt::format("; constrained by ranges {:.0f} % of it", 100.0 * constrained_m / degenerate_m);
  }
  return line + '\n';
}

/// "ranges: 9602 used, 638 rejected (412 nlos, 201 outlier, 25 no pose)"; nothing without ranges.
std::string ranges_line(const MapSummary& summary) {
  const drive::RangeTally& ranges = summary.ranges;
  if (ranges.total == 0) return {};
  std::vector<std::pair<std::size_t, std::string>> reasons;
  for (std::size_t i = 1; i < ranges.by_reason.size(); ++i) {
    if (ranges.by_reason[i] == 0) continue;
    std::string name(ranging::kRangeReasonNames[i]);
    std::replace(name.begin(), name.end(), '_', ' ');
    reasons.emplace_back(ranges.by_reason[i], name);
  }
  std::stable_sort(reasons.begin(), reasons.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<std::string> parts;
  for (const auto& [n, name] : reasons) parts.push_back(fmt::format("{} {}", n, name));
  std::string line =
      fmt::format("ranges: {} used, {} rejected", ranges.used(), ranges.total - ranges.used());
  if (!parts.empty()) line += fmt::format(" ({})", fmt::join(parts, ", "));
  return line + '\n';
}

void add(std::vector<std::string>& parts, std::uint64_t n, std::string_view what,
         std::string_view more) {
  if (n > 0) parts.push_back(fmt::format("{} {}", counted(n, what), more));
}

std::string gaps_of(const VehicleSummary& vehicle) {
  const drive::InputGaps& gaps = vehicle.input.gaps;
  std::vector<std::string> parts;
  add(parts, gaps.jumps, "clock jump", "closed");
  if (gaps.missing_s > 0.0) parts.push_back(fmt::format("{:.1f} s without scans", gaps.missing_s));
  if (gaps.imu_missing_s > 0.0) {
    parts.push_back(fmt::format("{:.1f} s without inertial data", gaps.imu_missing_s));
  }
  add(parts, gaps.late, "message", "late");
  add(parts, gaps.empty_scans, "scan", "empty");
  add(parts, gaps.imu_invalid, "inertial sample", "not usable");
  add(parts, gaps.undecodable, "message", "unreadable");
  add(parts, gaps.bytes_lost, "byte", "lost at the end");
  add(parts, vehicle.scans_dropped, "scan", "left out");
  if (vehicle.diverged_s > 0.0) {
    parts.push_back(
        fmt::format("{:.1f} s cut out where the odometry diverged", vehicle.diverged_s));
  }
  if (vehicle.keyframes == 0) parts.emplace_back("no map");
  if (parts.empty() && gaps.damaged) parts.emplace_back("damaged input, see the warnings");
  if (parts.empty()) return {};
  return fmt::format("{}: {}", vehicle.name, fmt::join(parts, ", "));
}

std::string gaps_line(const MapSummary& summary) {
  std::vector<std::string> parts;
  for (const VehicleSummary& vehicle : summary.vehicles) {
    const std::string gaps = gaps_of(vehicle);
    if (!gaps.empty()) parts.push_back(gaps);
  }
  if (!parts.empty()) return fmt::format("gaps: {}", fmt::join(parts, "; "));
  return summary.checks.keyframes_checked > 0 ? "gaps: none" : "gaps: none in the data";
}

/// "check: 41 of 43 keyframes see enough walls of the map; nothing contradicts it"
std::string check_line(const MapSummary& summary) {
  const drive::CheckTally& checks = summary.checks;
  if (checks.keyframes == 0) return {};
  std::string line = "check: no keyframe sees enough walls to contradict the map";
  if (checks.keyframes_checked > 0) {
    line = fmt::format("check: {} of {} keyframes see enough walls to contradict the map",
                       checks.keyframes_checked, checks.keyframes);
    if (checks.contradictions == 0) line += "; no contradiction";
  }
  if (checks.contradictions > 0) {
    line += fmt::format("; {}, see the findings", counted(checks.contradictions, "contradiction"));
  }
  return line + '\n';
}

}  // namespace

std::string summary_text(const MapSummary& summary, const std::string& page) {
  const std::string paths = joined(
      summary, " + ", [](const VehicleSummary& v) { return fmt::format("{:.0f}", v.path_m); });
  std::size_t keyframes = 0;
  for (const VehicleSummary& vehicle : summary.vehicles) keyframes += vehicle.keyframes;
  std::string text = page + '\n' + vehicles_line(summary) + '\n';
  text += fmt::format("path {} m, {}, {}", paths, counted(keyframes, "keyframe"),
                      counted(summary.map_points, "map point"));
  if (summary.removed_points > 0)
    text += fmt::format(", {} moving removed", summary.removed_points);
  text += loops_words(summary);
  text += '\n' + rounds_line(summary) + degenerate_line(summary) + sigma_line(summary);
  text += ranges_line(summary);
  text += check_line(summary);
  text += gaps_line(summary);
  return text + '\n';
}

std::string input_text(const drive::InputReport& report) {
  std::string text =
      fmt::format("lidar of {}: {}", report.vehicle, config::pose_in_words(report.T_body_lidar));
  if (!report.T_body_lidar_origin.empty()) text += fmt::format(" ({})", report.T_body_lidar_origin);
  if (!report.cloud_format.summary.empty()) {
    text += fmt::format("\nclouds of {}: {}", report.vehicle, report.cloud_format.summary);
  }
  if (report.clock_offset.value_s != 0.0) {
    text +=
        fmt::format("\nclock of {}: {:+.4f} s added to all stamps ({})", report.vehicle,
                    report.clock_offset.value_s,
                    report.clock_offset.origin.empty() ? "settings" : report.clock_offset.origin);
  }
  if (report.lidar_time_offset.value_s != 0.0) {
    text += fmt::format(
        "\ntime offset of {}: {:+.4f} s added to LiDAR stamps ({})", report.vehicle,
        report.lidar_time_offset.value_s,
        report.lidar_time_offset.origin.empty() ? "settings" : report.lidar_time_offset.origin);
  }
  if (!report.has_imu) text += fmt::format("\n{}: no inertial data, LiDAR alone", report.vehicle);
  return text;
}

Result<std::vector<Requirement>> parse_requirements(const std::vector<std::string>& texts) {
  const std::vector<std::string> known{"connected", "max_sigma_m", "min_loops"};
  std::vector<Requirement> requirements;
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    Requirement requirement{text.substr(0, equals), 0.0};
    if (std::find(known.begin(), known.end(), requirement.name) == known.end()) {
      return fail(ErrorCode::kUsage, "--require",
                  fmt::format("'{}' is no condition", requirement.name.substr(0, 60)),
                  config::suggestion(requirement.name, known));
    }
    const bool wants_value = requirement.name != "connected";
    const bool has_value =
        equals != std::string::npos &&
        config::parse_double(std::string_view(text).substr(equals + 1), requirement.limit) &&
        requirement.limit >= 0.0;
    if (wants_value ? !has_value : equals != std::string::npos) {
      return fail(ErrorCode::kUsage, "--require",
                  fmt::format("'{}' is no condition", text.substr(0, 60)),
                  "Write connected, max_sigma_m=0.5 or min_loops=1.");
    }
    requirements.push_back(std::move(requirement));
  }
  return requirements;
}

std::vector<std::string> broken_requirements(const std::vector<Requirement>& requirements,
                                             const MapSummary& summary) {
  std::vector<std::string> broken;
  for (const Requirement& requirement : requirements) {
    if (requirement.name == "connected" && !drive::is_connected(summary.fleet)) {
      broken.push_back("required connected: the vehicles are not joined in one frame");
    }
    if (requirement.name == "min_loops") {
      const auto& loops = summary.fleet.loops;
      const auto closed = std::count_if(loops.begin(), loops.end(),
                                        [](const fleet::LoopVerdict& l) { return l.accepted; });
      if (static_cast<double>(closed) < requirement.limit) {
        broken.push_back(fmt::format("required min_loops={}: {} closed", requirement.limit,
                                     counted(static_cast<std::size_t>(closed), "loop")));
      }
    }
    if (requirement.name != "max_sigma_m") continue;
    for (const VehicleSummary& vehicle : summary.vehicles) {
      if (vehicle.sigma_max_m <= requirement.limit) continue;
      const std::string what = has_pose(vehicle)
                                   ? fmt::format("reaches {:.2f} m", vehicle.sigma_max_m)
                                   : std::string("has no pose");
      broken.push_back(
          fmt::format("required max_sigma_m={}: {} {}", requirement.limit, vehicle.name, what));
    }
  }
  return broken;
}

int exit_code_of(const MapSummary& summary, int signal_number) {
  if (signal_number != 0 && summary.status == drive::RunStatus::kInterrupted) {
    return 128 + signal_number;
  }
  const bool gaps = summary.gaps || summary.status != drive::RunStatus::kComplete;
  return gaps ? kExitGaps : kExitDone;
}

}  // namespace rali::cli
