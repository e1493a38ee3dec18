#include "rali/inspect/fleet_study.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>

#include <fmt/format.h>

#include "rali/inspect/make_finding.hpp"

namespace rali::inspect {
namespace {

constexpr double kLatencyMax_s = 0.3;
constexpr double kLatencyLimit_s = 0.02, kSigmaMax_s = 0.03;
constexpr double kDriven_m = 3.0;    ///< minimum extent of a moving track
constexpr double kStanding_m = 0.3;  ///< maximum extent at standstill: LiDAR odometry drifts
constexpr double kOverlapMin_s = 10.0;
constexpr double kBootClock_s = 1e8;  ///< all clocks that count from 1970 are above

using ranging::Track;
using Ranges = std::span<const std::pair<Time, double>>;

/// The segment between gaps with the longest duration.
Track longest_piece(Track track) {
  Track best;
  for (std::size_t begin = 0; begin < track.size();) {
    std::size_t end = begin;
    while (end < track.size() && track[end].piece == track[begin].piece) ++end;
    const Track piece = track.subspan(begin, end - begin);
    if (best.empty() || seconds_between(piece.front().t, piece.back().t) >
                            seconds_between(best.front().t, best.back().t)) {
      best = piece;
    }
    begin = end;
  }
  return best;
}

/// One vehicle's recordings, combined.
struct Vehicle {
  std::string name;
  Time t_start, t_end;
  Track track;
};

std::vector<Vehicle> vehicles_of(const std::vector<DoctorReport>& recordings) {
  std::vector<Vehicle> vehicles;
  for (const DoctorReport& r : recordings) {
    if (r.t_start == r.t_end) continue;
    const auto known = std::find_if(vehicles.begin(), vehicles.end(),
                                    [&](const Vehicle& v) { return v.name == r.vehicle; });
    if (known == vehicles.end()) {
      vehicles.push_back({r.vehicle, r.t_start, r.t_end, r.track});
      continue;
    }
    known->t_start = std::min(known->t_start, r.t_start);
    known->t_end = std::max(known->t_end, r.t_end);
    if (extent_m(known->track) < extent_m(r.track)) known->track = r.track;
  }
  return vehicles;
}

void report_pair(const Vehicle& a, const Vehicle& b, const RangeStudy& study, FindingList& out) {
  const auto ranges = study.between(a.name, b.name);
  if (ranges.empty()) return;
  std::optional<ranging::StampOffset> found;
  for (const auto& [driver, peer] : {std::pair(&a, &b), std::pair(&b, &a)}) {
    if (peer->track.empty() || extent_m(peer->track) > kStanding_m) continue;
    found = latency_by_motion(driver->track, ranges);
    if (found) break;
  }
  const std::string pair = a.name + '-' + b.name;
  if (!found) {
    out.push_back(make_finding(
        "D16", Severity::kInfo, "",
        {fmt::format("{}: latency of the ranges not observable in what was looked at", pair), "",
         "Let one vehicle stand while the other drives past it, with walls in view."}));
    return;
  }
  const bool late = std::abs(found->value_s) > std::max(kLatencyLimit_s, 3.0 * found->sigma_s);
  out.push_back(make_finding(
      "D16", late ? Severity::kWarning : Severity::kInfo, "",
      {fmt::format(
           "{}: ranges are {:.0f} ms old at their stamps (sigma {:.0f} ms, {} ranges, {:.2f} "
           "m left)",
           pair, 1e3 * found->value_s, 1e3 * found->sigma_s, found->ranges, found->residual_m),
       late ? "while driving, each range is off by latency times speed" : "",
       late ? fmt::format("Leave ranges.latency_s at auto, or set it to {:.3f}.", found->value_s)
            : ""},
      {found->value_s, kLatencyLimit_s}));
}

void report_stamps(const RangeStudy& study, FindingList& out) {
  for (const auto& [topic, radios] : study.radios()) {
    const bool own = radios.without_stamp == 0;
    out.push_back(make_finding(
        "D16", Severity::kInfo, topic,
        {own ? "ranges carry stamps of their own"
             : "ranges carry no stamps: rali map takes the radio's own clock, set by the arrivals",
         "", ""},
        {static_cast<double>(radios.without_stamp), 0.0}));
  }
}

Finding overlap_finding(const Vehicle& first, const Vehicle& v, bool separate) {
  const double late_s = seconds_between(first.t_start, v.t_start);
  const double together_s =
      seconds_between(std::max(first.t_start, v.t_start), std::min(first.t_end, v.t_end));
  const std::string starts = fmt::format("{} starts {:.1f} s {} {}", v.name, std::abs(late_s),
                                         late_s < 0.0 ? "before" : "after", first.name);
  if (separate) {
    return make_finding("D17", Severity::kInfo, "", {starts + "; clock: separate", "", ""},
                        {late_s, 0.0});
  }
  const bool boot = first.t_start.s() < kBootClock_s || v.t_start.s() < kBootClock_s;
  if (boot && std::abs(late_s) > kBootClock_s) {
    return make_finding(
        "D17", Severity::kError, "",
        {fmt::format(
             "clocks of {} and {} have different origins: stamps begin at {:.0f} s and {:.0f} s",
             first.name, v.name, first.t_start.s(), v.t_start.s()),
         "ranges between them fit no pose", "Synchronise the computers' clocks before recording."},
        {late_s, 0.0});
  }
  // For short recordings, half of the duration is sufficient.
  const double shorter_s =
      std::min(seconds_between(first.t_start, first.t_end), seconds_between(v.t_start, v.t_end));
  const double limit_s = std::min(kOverlapMin_s, 0.5 * shorter_s);
  if (together_s >= limit_s) {
    return make_finding("D17", Severity::kInfo, "",
                        {fmt::format("{}; both run for {:.0f} s", starts, together_s), "", ""},
                        {late_s, limit_s});
  }
  return make_finding(
      "D17", Severity::kWarning, "",
      {together_s > 0.0 ? fmt::format("{}; both run for {:.1f} s only", starts, together_s)
                        : starts + "; the recordings do not overlap in time",
       "ranges between them do not join them",
       "Set clock: separate if they were recorded at different times; else synchronise the "
       "clocks."},
      {together_s, limit_s});
}

}  // namespace

std::optional<ranging::StampOffset> latency_by_motion(Track track, Ranges ranges) {
  ranging::StandWindow window{longest_piece(track), {}};
  if (extent_m(window.track) < kDriven_m) return std::nullopt;
  for (const auto& [t, range_m] : ranges) window.ranges.push_back({t, range_m});
  const auto found = ranging::find_stamp_offset({&window, 1}, kLatencyMax_s);
  return found && found->sigma_s < kSigmaMax_s ? found : std::nullopt;
}

void report_latency(const std::vector<DoctorReport>& recordings, const RangeStudy& ranges,
                    FindingList& out) {
  const std::vector<Vehicle> vehicles = vehicles_of(recordings);
  for (std::size_t b = 0; b < vehicles.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) report_pair(vehicles[a], vehicles[b], ranges, out);
  }
  report_stamps(ranges, out);
}

void report_overlap(const std::vector<DoctorReport>& recordings, bool separate, FindingList& out) {
  const std::vector<Vehicle> vehicles = vehicles_of(recordings);
  for (std::size_t i = 1; i < vehicles.size(); ++i) {
    out.push_back(overlap_finding(vehicles.front(), vehicles[i], separate));
  }
}

}  // namespace rali::inspect
