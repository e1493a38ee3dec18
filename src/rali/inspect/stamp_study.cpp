#include "rali/inspect/stamp_study.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "rali/base/counted.hpp"
#include "rali/inspect/make_finding.hpp"

namespace rali::inspect {
namespace {

/// A clock step of one second must be detected, whatever the rounding of its stamps.
constexpr double kJump_s = 0.8;
constexpr double kGapPeriods = 1.5;

double quantile(std::vector<double> values, double fraction) {
  if (values.empty()) return 0.0;
  const auto k = static_cast<std::ptrdiff_t>(fraction * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + k, values.end());
  return values[static_cast<std::size_t>(k)];
}

/// Period over many messages: jitter of single stamps, which lengthens one step and shortens the
/// next, does not count.
double long_period_s(std::vector<Time> times, double otherwise_s) {
  constexpr std::size_t kMessages = 20;
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  std::vector<double> periods;
  for (std::size_t i = kMessages; i < times.size(); ++i) {
    periods.push_back(seconds_between(times[i - kMessages], times[i]) / kMessages);
  }
  return periods.empty() ? otherwise_s : quantile(std::move(periods), 0.5);
}

double step_s(Time from, Time to) { return seconds_between(from, to); }

}  // namespace

double StampStatistics::missing_fraction() const {
  const auto all = static_cast<double>(messages + missing);
  return all > 0.0 ? static_cast<double>(missing) / all : 0.0;
}

StampStatistics study_stamps(std::span<const drive::StampPair> stamps) {
  StampStatistics s;
  s.messages = stamps.size();
  if (stamps.empty()) return s;
  s.decision = drive::decide_stamps(stamps);
  const bool by_record = s.decision.rule == drive::StampRule::kRecord;
  const auto time_of = [by_record](const drive::StampPair& p) {
    return by_record ? p.record : p.header;
  };
  std::vector<double> steps, record_steps, offsets;
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    if (stamps[i].header.ns == 0) ++s.zero;
    offsets.push_back(step_s(stamps[i].record, stamps[i].header));
    if (i == 0) continue;
    const double header_step = step_s(stamps[i - 1].header, stamps[i].header);
    const double record_step = step_s(stamps[i - 1].record, stamps[i].record);
    record_steps.push_back(record_step);
    if (header_step == 0.0) ++s.repeated;
    if (header_step < 0.0) ++s.backward;
    if (std::abs(header_step - record_step) > kJump_s) ++s.jumps;
    const double step = step_s(time_of(stamps[i - 1]), time_of(stamps[i]));
    if (step > 0.0) steps.push_back(step);
  }
  s.period_s = quantile(steps, 0.5);
  s.span_s = step_s(time_of(stamps.front()), time_of(stamps.back()));
  s.clock_offset_s = quantile(offsets, 0.5);
  s.delay_jitter_s = quantile(offsets, 0.95) - quantile(offsets, 0.05);
  if (!(s.period_s > 0.0)) return s;
  std::vector<Time> times;
  for (const drive::StampPair& p : stamps) times.push_back(time_of(p));
  const double period_s = long_period_s(std::move(times), s.period_s);
  double covered_s = 0.0;
  std::int64_t covered = 0;
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    const double step = step_s(time_of(stamps[i - 1]), time_of(stamps[i]));
    // A gap in the header stamps only, from a clock step, is not a missing message.
    const double recorded = step_s(stamps[i - 1].record, stamps[i].record);
    if (step > 3600.0 || std::abs(step - recorded) > kJump_s) continue;
    covered_s += step;
    covered += step != 0.0 ? 1 : 0;
    if (step < kGapPeriods * s.period_s) continue;
    s.missing += static_cast<std::uint64_t>(std::max(std::round(step / s.period_s) - 1.0, 0.0));
    if (step <= s.longest_gap_s) continue;
    s.longest_gap_s = step;
    s.t_longest_gap = time_of(stamps[i - 1]);
  }
  const double absent = std::round(covered_s / period_s) - static_cast<double>(covered);
  if (absent < static_cast<double>(s.missing)) {
    s.missing = static_cast<std::uint64_t>(std::max(absent, 0.0));
  }
  const auto batched = std::count_if(record_steps.begin(), record_steps.end(),
                                     [&s](double step) { return step < 0.1 * s.period_s; });
  s.batch_fraction = static_cast<double>(batched) /
                     std::max<double>(1.0, static_cast<double>(record_steps.size()));
  return s;
}

void report_rate(const StampStatistics& s, const std::string& id, const std::string& what,
                 const std::string& topic, FindingList& out) {
  const bool lidar = id == "D01";
  const double rate_min_hz = lidar ? 3.0 : 50.0;
  if (s.messages < 2 || s.period_s <= 0.0) {
    out.push_back(make_finding(id, Severity::kError, topic,
                               {fmt::format("{} {}", s.messages, what),
                                "there is too little to make a map of", "Record again."},
                               {static_cast<double>(s.messages), 2.0}));
    return;
  }
  const bool slow = s.rate_hz() < rate_min_hz;
  out.push_back(make_finding(
      id, slow ? Severity::kWarning : Severity::kInfo, topic,
      {fmt::format("{} {} in {:.1f} s, {:.1f} Hz", s.messages, what, s.span_s, s.rate_hz()),
       slow ? "fast turns are lost between two of them" : "",
       slow ? fmt::format("Record at {:.0f} Hz or more.", lidar ? 10.0 : 100.0) : ""},
      {s.rate_hz(), rate_min_hz}));
  if (s.missing == 0) return;
  const double long_s = lidar ? 1.0 : 0.1;
  const bool serious = s.missing_fraction() > 0.2 || s.longest_gap_s > 10.0 * long_s;
  const bool notable = s.missing_fraction() > 0.01 || s.longest_gap_s > long_s;
  out.push_back(make_finding(
      id,
      serious   ? Severity::kError
      : notable ? Severity::kWarning
                : Severity::kInfo,
      topic,
      {fmt::format("{} of the {} are missing, longest gap {:.2f} s at {:.3f}",
                   percent(s.missing_fraction()), what, s.longest_gap_s, s.t_longest_gap.s()),
       "the pose is only predicted across a gap",
       "Record to a faster disk, or with a larger buffer of the recorder and the driver."},
      {s.longest_gap_s, long_s}));
}

void report_stamps(const StampStatistics& s, const std::string& topic, FindingList& out) {
  if (s.decision.rule == drive::StampRule::kRecord) {
    out.push_back(make_finding(
        "D04", Severity::kWarning, topic,
        {s.decision.reason + ": the record times are taken",
         "the delay of the network becomes an error in time", "Let the driver stamp its messages."},
        {static_cast<double>(s.zero), 0.0}));
    return;
  }
  const auto count = [&](std::uint64_t n, const char* what, const char* text, const char* effect) {
    if (n == 0) return;
    out.push_back(make_finding("D04", Severity::kWarning, topic,
                               {counted(n, what) + text, effect, ""},
                               {static_cast<double>(n), 0.0}));
  };
  count(s.zero, "stamp", " of zero", "these messages are left out");
  count(s.repeated, "stamp", " equal to the one before", "repeats are left out");
  count(s.backward, "stamp", " older than the one before",
        "they are sorted within 0.5 s, later ones are left out");
  count(s.jumps, "jump", " of the clock against the record time",
        "jumps are closed by the record time");
  if (std::abs(s.clock_offset_s) > drive::kClockSplitS) {
    out.push_back(make_finding(
        "D04", Severity::kInfo, topic,
        {fmt::format("stamps differ from the record time by {:.3f} s", s.clock_offset_s),
         "harmless as long as all sensors of the vehicle do the same", ""},
        {s.clock_offset_s, drive::kClockSplitS}));
  }
}

void report_clock_split(const StampStatistics& lidar, const StampStatistics& imu,
                        const std::string& imu_topic, FindingList& out) {
  if (lidar.messages == 0 || imu.messages == 0) return;
  const double split_s = imu.clock_offset_s - lidar.clock_offset_s;
  if (std::abs(split_s) <= drive::kClockSplitS) return;
  out.push_back(make_finding(
      "D04", Severity::kError, imu_topic,
      {fmt::format("LiDAR and IMU run on two clocks, {:.3f} s apart", split_s),
       "they can only be brought together by the record times, with the delay of each",
       "Synchronise the sensors (PTP, PPS) or let the driver take the computer's time."},
      {split_s, drive::kClockSplitS}));
}

}  // namespace rali::inspect
