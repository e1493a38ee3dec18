#include "rali/drive/ranges/range_findings.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "rali/base/counted.hpp"

namespace rali::drive {
namespace {

using ranging::RangeReason;

Finding finding(const char* id, std::string text, std::string remedy) {
  Finding f;
  f.id = id;
  f.text = std::move(text);
  f.remedy = std::move(remedy);
  return f;
}

std::uint64_t messages_of(const std::string& topic, const std::vector<InputReport>& reports) {
  std::uint64_t sum = 0;
  for (const InputReport& report : reports) {
    const auto found = report.range_messages.find(topic);
    if (found != report.range_messages.end()) sum += found->second;
  }
  return sum;
}

std::string remedy_of(RangeReason reason) {
  switch (reason) {
    case RangeReason::kUnknownId:
      return "Name the radios in ranges.sources (ids) and the antennas of each vehicle.";
    case RangeReason::kOutOfLimits:
      return "They must be metres within ranges.limits_m.";
    case RangeReason::kLate:
      return "They must be on the clock of the recordings, see ranges.stamp.";
    case RangeReason::kNoPose:
      return "A range needs two vehicles with data at its time whose places in the map are known "
             "(priors, or ranges and scans where the LiDAR is not degenerate).";
    case RangeReason::kNotNeeded:
      return "Preset paper uses ranges at keyframes that its detector calls degenerate: see "
             "vehicle.paper_degree.deg_above and odometry.paper.keyframe_s, or take preset robust.";
    default:
      return "See ranges.csv and rali doctor.";
  }
}

/// All ranges lie before or after all data: reported as such, since other findings would mislead.
std::optional<Finding> other_clock(const RangeTally& tally,
                                   const std::vector<InputReport>& reports) {
  std::optional<Time> begin, end;
  for (const InputReport& report : reports) {
    if (report.scans == 0) continue;
    begin = std::min(begin.value_or(report.t_start), report.t_start);
    end = std::max(end.value_or(report.t_end), report.t_end);
  }
  if (!begin || (tally.last >= *begin && tally.first <= *end)) return std::nullopt;
  return finding("ranges.other_clock",
                 fmt::format("none of {} was used: they are stamped {:.3f} to {:.3f} s, the "
                             "recordings {:.3f} to {:.3f} s",
                             counted(tally.total, "range"), tally.first.s(), tally.last.s(),
                             begin->s(), end->s()),
                 "Put both on one clock.");
}

/// D16: age of ranges at their stamps. The filters estimate it, as far as their prior allows.
std::optional<Finding> latency_finding(const MapJob& job, const std::vector<InputReport>& reports) {
  if (job.ranges.latency_s) return std::nullopt;
  std::vector<std::optional<RangeLatency>> vehicles;
  for (const InputReport& report : reports) vehicles.push_back(report.range_latency);
  const std::optional<RangeLatency> latency = combined(vehicles);
  if (!latency) return std::nullopt;
  const double prior_s = job.vehicles.front().settings.ranging.bias.tau_sigma_s;
  const bool large = std::abs(latency->value_s) > std::max(prior_s, 3.0 * *latency->sigma_s);
  if (!large && *latency->sigma_s > prior_s) return std::nullopt;  // metrics.json contains it
  Finding f = finding(
      "D16",
      fmt::format("ranges are {} old at their stamps, by the motion", latency_words(*latency)),
      large ? fmt::format("Set ranges.latency_s: {:.3f}.", latency->value_s) : "");
  f.severity = large ? Severity::kWarning : Severity::kInfo;
  f.value = latency->value_s;
  f.limit = prior_s;
  return f;
}

}  // namespace

Finding no_topic_finding(const std::string& topic) {
  return finding("ranges.no_topic", fmt::format("no recording has ranges on {}", topic),
                 "See rali info for its topics and types.");
}

FindingList range_findings(const RangeTally& tally, const MapJob& job,
                           const std::vector<InputReport>& reports, bool placing) {
  FindingList list;
  for (const RangeTopic& topic : job.ranges.topics) {
    if (messages_of(topic.topic, reports) > 0) continue;
    list.push_back(no_topic_finding(topic.topic));
  }
  if (auto latency = latency_finding(job, reports)) list.push_back(std::move(*latency));
  if (tally.total == 0 || tally.used() > 0) return list;
  if (!job.known.common_clock) {
    list.push_back(finding("ranges.separate",
                           fmt::format("{} not used: the vehicles share no clock (clock: separate)",
                                       counted(tally.total, "range")),
                           "Set clock: synchronised if they do."));
    return list;
  }
  bool wanted = false;
  for (const VehicleJob& vehicle : job.vehicles) wanted |= vehicle.settings.ranging.use;
  if (!wanted) return list;
  if (auto odd = other_clock(tally, reports)) {
    list.push_back(std::move(*odd));
    return list;
  }
  const RangeReason reason = tally.commonest_refusal();
  const std::string refused =
      fmt::format("{} of them for {}", tally.by_reason[static_cast<std::size_t>(reason)],
                  ranging::kRangeReasonNames[static_cast<std::size_t>(reason)]);
  const std::string ranges = counted(tally.total, "range");
  if (placing) {
    list.push_back(finding("ranges.none_used",
                           fmt::format("{} placed the vehicles relative to each other; none "
                                       "corrected a vehicle while it drove, {}",
                                       ranges, refused),
                           ""));
    list.back().severity = Severity::kInfo;
    return list;
  }
  list.push_back(finding("ranges.none_used",
                         fmt::format("none of {} was used, {}", ranges, refused),
                         remedy_of(reason)));
  return list;
}

}  // namespace rali::drive
