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
constexpr std::size_t kRingSweeps = 20;  ///< the rings of a sensor do not change
constexpr double kSpanMin_s = 0.02, kSpanMax_s = 0.2;

double share_of(std::uint64_t part, std::uint64_t all) {
  return all > 0 ? static_cast<double>(part) / static_cast<double>(all) : 0.0;
}

}  // namespace

void CloudStudy::add(const sensor::LidarScan& scan, std::size_t points) {
  ++sweeps_;
  points_ += points;
  usable_ += scan.size();
  nan_ += scan.dropped_nan;
  out_of_range_ += scan.dropped_range;
  if (scan.size() == 0) ++empty_;
  if (!scan.has_point_times) ++untimed_sweeps_;
  span_sum_s_ += seconds_between(scan.t_begin, scan.t_end);
  if (scan.has_rings && sweeps_ <= kRingSweeps) add_rings(scan);
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

double CloudStudy::points_per_sweep() const {
  return sweeps_ > 0 ? static_cast<double>(usable_) / static_cast<double>(sweeps_) : 0.0;
}

void CloudStudy::report(const wire::CloudFormat& format, const std::string& topic,
                        FindingList& out) const {
  if (sweeps_ == 0) return;
  for (Finding finding : format.findings) {
    finding.topic = topic;
    out.push_back(std::move(finding));
  }
  const double usable = points_per_sweep();
  const bool few = usable < kFewPoints;
  out.push_back(make_finding("D01", few ? Severity::kWarning : Severity::kInfo, topic,
                             {fmt::format("{:.0f} usable points per sweep", usable),
                              few ? "there may be too little to match" : "",
                              few ? "Check range limits, self box and the driver's filters." : ""},
                             {usable, kFewPoints}));
  if (empty_ > 0) {
    out.push_back(make_finding(
        "D01", share_of(empty_, sweeps_) > 0.2 ? Severity::kError : Severity::kWarning, topic,
        {counted(empty_, "sweep") + " without a usable point", "the pose is only predicted there",
         "Check the LiDAR's cover."},
        {static_cast<double>(empty_), 0.0}));
  }
  const double nan = share_of(nan_, points_);
  out.push_back(make_finding(
      "D05", nan > kNanMax ? Severity::kWarning : Severity::kInfo, topic,
      {fmt::format("{:.2g} % of the points are NaN or zero: removed; {:.2g} % are out of range",
                   100.0 * nan, 100.0 * share_of(out_of_range_, points_)),
       "", ""},
      {nan, kNanMax}));
  report_times(format, topic, out);
  report_rings(format, topic, out);
}

void CloudStudy::report_times(const wire::CloudFormat& format, const std::string& topic,
                              FindingList& out) const {
  if (!format.summary.empty()) {
    out.push_back(make_finding("D02", Severity::kInfo, topic, {format.summary, "", ""}));
  }
  if (untimed_sweeps_ == sweeps_) return;  // the format's own finding says so
  const double span_s = span_sum_s_ / static_cast<double>(sweeps_ - untimed_sweeps_);
  const bool odd = span_s < kSpanMin_s || span_s > kSpanMax_s;
  out.push_back(make_finding(
      "D02", odd ? Severity::kWarning : Severity::kInfo, topic,
      {fmt::format("points of a sweep span {:.1f} ms", 1e3 * span_s),
       odd ? "no LiDAR turns like this: the unit may be wrong, or the clouds are cut" : "",
       odd ? "Set lidar.point_time." : ""},
      {span_s, odd && span_s > kSpanMax_s ? kSpanMax_s : kSpanMin_s}));
  const bool stamp_told = std::any_of(format.findings.begin(), format.findings.end(),
                                      [](const Finding& f) { return f.id == "D03"; });
  if (stamp_told) return;
  out.push_back(
      make_finding("D03", Severity::kInfo, topic,
                   {fmt::format("the header stamp names the {} of the sweep",
                                format.header_stamp == wire::HeaderStamp::kEnd ? "end" : "start"),
                    "", ""}));
}

void CloudStudy::report_rings(const wire::CloudFormat& format, const std::string& topic,
                              FindingList& out) const {
  if (rings_.empty()) {
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
