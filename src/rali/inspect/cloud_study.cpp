#include "rali/inspect/cloud_study.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "rali/base/counted.hpp"
#include "rali/inspect/make_finding.hpp"

namespace rali::inspect {
namespace {

constexpr double kNanMax = 0.5;
constexpr double kFewPoints = 2000.0;
constexpr std::size_t kRingScans = 20;  ///< rings to count are constant, so few scans suffice
/// Missing returns from sky and far walls change over many scans; a fault appears from one scan to
/// the next.
constexpr float kNanJump = 0.15F;
constexpr std::size_t kNanJumpScans = 3;  ///< on each side of the jump
constexpr double kSpanMin_s = 0.02, kSpanMax_s = 0.2;

double fraction_of(std::uint64_t part, std::uint64_t all) {
  return all > 0 ? static_cast<double>(part) / static_cast<double>(all) : 0.0;
}

}  // namespace

void CloudStudy::add(const sensor::LidarScan& scan, std::size_t points) {
  ++scans_;
  points_ += points;
  usable_ += scan.size();
  nan_ += scan.dropped_nan;
  out_of_range_ += scan.dropped_range;
  if (scan.size() == 0) ++empty_;
  if (!scan.has_point_times && scan.dropped_time == 0) ++untimed_scans_;
  nan_fractions_.push_back(static_cast<float>(fraction_of(scan.dropped_nan, points)));
  const bool at_once = scan.has_point_times && scan.size() > 1 && scan.t_start == scan.t_end;
  if (at_once || scan.dropped_time > scan.size()) ++odd_time_scans_;
  span_sum_s_ += seconds_between(scan.t_start, scan.t_end);
  if (scan.has_rings && scans_ <= kRingScans) add_rings(scan);
}

void CloudStudy::add_rings(const sensor::LidarScan& scan) {
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (scan.ring[i] >= rings_.size()) rings_.resize(std::size_t{scan.ring[i]} + 1);
    const auto x = static_cast<double>(scan.x_m[i]), y = static_cast<double>(scan.y_m[i]);
    Ring& ring = rings_[scan.ring[i]];
    ++ring.points;
    ring.elevation_sum_rad += std::atan2(static_cast<double>(scan.z_m[i]), std::hypot(x, y));
  }
}

double CloudStudy::points_per_scan() const {
  return scans_ > 0 ? static_cast<double>(usable_) / static_cast<double>(scans_) : 0.0;
}

void CloudStudy::report(const wire::CloudFormat& format, const std::string& topic,
                        FindingList& out) const {
  if (scans_ == 0) return;
  for (Finding finding : format.findings) {
    if (finding.id == "D05") continue;  // of the first clouds; the one for all clouds follows below
    finding.topic = topic;
    out.push_back(std::move(finding));
  }
  const double usable = points_per_scan();
  const bool few = usable < kFewPoints;
  out.push_back(make_finding("D01", few ? Severity::kWarning : Severity::kInfo, topic,
                             {fmt::format("{:.0f} usable points per scan", usable),
                              few ? "there may be too little to match" : "",
                              few ? "Check range limits, self box and the driver's filters." : ""},
                             {usable, kFewPoints}));
  if (empty_ > 0) {
    out.push_back(make_finding(
        "D01", fraction_of(empty_, scans_) > 0.2 ? Severity::kError : Severity::kWarning, topic,
        {counted(empty_, "scan") + " without a usable point", "the pose is only predicted there",
         "Check the LiDAR's cover."},
        {static_cast<double>(empty_), 0.0}));
  }
  const double nan = fraction_of(nan_, points_);
  out.push_back(
      make_finding("D05", nan > kNanMax ? Severity::kWarning : Severity::kInfo, topic,
                   {fmt::format("{} of the points are NaN or zero: removed; {} are out of range",
                                percent(nan), percent(fraction_of(out_of_range_, points_))),
                    "", ""},
                   {nan, kNanMax}));
  report_nan_jumps(topic, out);
  report_times(format, topic, out);
  report_rings(format, topic, out);
}

void CloudStudy::report_nan_jumps(const std::string& topic, FindingList& out) const {
  constexpr std::size_t n = kNanJumpScans;
  std::size_t jumps = 0, worst = 0;
  float maximum = 0.0F;
  for (std::size_t i = n; i + n <= nan_fractions_.size(); ++i) {
    const auto at = nan_fractions_.begin() + static_cast<std::ptrdiff_t>(i);
    const float before = *std::max_element(at - static_cast<std::ptrdiff_t>(n), at);
    const float after = *std::min_element(at, at + static_cast<std::ptrdiff_t>(n));
    if (after - before < kNanJump) continue;
    ++jumps;
    if (after - before <= maximum) continue;
    maximum = after - before;
    worst = i;
  }
  if (jumps == 0) return;
  const auto percent = [this](std::size_t i) {
    return 100.0 * static_cast<double>(nan_fractions_[i]);
  };
  out.push_back(make_finding(
      "D05", Severity::kWarning, topic,
      {fmt::format(
           "the fraction of points that are NaN or zero jumps from {:.0f} to {:.0f} % within "
           "one scan ({}, the largest at scan {})",
           percent(worst - 1), percent(worst), counted(jumps, "jump"), worst),
       "fewer points to match", "Check cover, cable and supply of the LiDAR, and its driver."},
      {static_cast<double>(maximum), static_cast<double>(kNanJump)}));
}

void CloudStudy::report_odd_times(const std::string& topic, FindingList& out) const {
  if (odd_time_scans_ == 0) return;
  const double fraction = fraction_of(odd_time_scans_, scans_);
  out.push_back(
      make_finding("D02", fraction > 0.2 ? Severity::kError : Severity::kWarning, topic,
                   {fmt::format("{} whose point times are all alike or make no sense ({})",
                                counted(odd_time_scans_, "scan"), percent(fraction)),
                    "they cannot be undistorted, or are left out",
                    "Check the LiDAR's driver, or set lidar.point_time: azimuth."},
                   {fraction, 0.0}));
}

void CloudStudy::report_times(const wire::CloudFormat& format, const std::string& topic,
                              FindingList& out) const {
  if (!format.summary.empty()) {
    out.push_back(make_finding("D02", Severity::kInfo, topic, {format.summary, "", ""}));
  }
  report_odd_times(topic, out);
  const std::uint64_t without = untimed_scans_ + odd_time_scans_;
  if (without >= scans_) return;  // the format's own finding reports it
  const double span_s = span_sum_s_ / static_cast<double>(scans_ - without);
  const bool odd = span_s < kSpanMin_s || span_s > kSpanMax_s;
  out.push_back(make_finding(
      "D02", odd ? Severity::kWarning : Severity::kInfo, topic,
      {fmt::format("points of a scan span {:.1f} ms", 1e3 * span_s),
       odd ? "no LiDAR turns like this: the unit may be wrong, or the clouds are cut" : "",
       odd ? "Set lidar.point_time." : ""},
      {span_s, odd && span_s > kSpanMax_s ? kSpanMax_s : kSpanMin_s}));
  const bool stamp_reported = std::any_of(format.findings.begin(), format.findings.end(),
                                          [](const Finding& f) { return f.id == "D03"; });
  if (stamp_reported) return;
  out.push_back(
      make_finding("D03", Severity::kInfo, topic,
                   {fmt::format("the header stamp names the {} of the scan",
                                format.header_stamp == wire::HeaderStamp::kEnd ? "end" : "start"),
                    "", ""}));
}

void CloudStudy::report_rings(const wire::CloudFormat& format, const std::string& topic,
                              FindingList& out) const {
  const auto of_format = [](const Finding& f) { return f.id == "D06"; };
  if (rings_.empty()) {
    if (std::any_of(format.findings.begin(), format.findings.end(), of_format)) return;
    out.push_back(make_finding("D06", Severity::kInfo, topic,
                               {"no ring numbers: neighbours are found by direction", "", ""}));
    return;
  }
  std::size_t used = 0, up = 0, down = 0;
  double last_rad = 0.0;
  for (const Ring& ring : rings_) {
    if (ring.points < 10) continue;
    const double elevation_rad = ring.elevation_sum_rad / static_cast<double>(ring.points);
    if (used > 0) (elevation_rad > last_rad ? up : down) += 1;
    last_rad = elevation_rad;
    ++used;
  }
  const char* order = down == 0 ? "upwards"
                      : up == 0 ? "downwards"
                                : "not by elevation, which is fine";
  const bool lost = format.rings > 0 && used * 2 < format.rings;
  out.push_back(make_finding(
      "D06", lost ? Severity::kWarning : Severity::kInfo, topic,
      {fmt::format("{} of {} rings hold points, numbered {}", used, rings_.size(), order),
       lost ? "half of the sensor sees nothing" : "", lost ? "Check cover and mount." : ""},
      {static_cast<double>(used), static_cast<double>(rings_.size())}));
}

}  // namespace rali::inspect
