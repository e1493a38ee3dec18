#include "rali/drive/input/event_outlet.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "rali/base/counted.hpp"

namespace rali::drive {
namespace {

constexpr double kWithoutImuMin = 0.1;  ///< fraction of the scans that is reported
constexpr double kWithoutImuMax = 0.5;  ///< beyond it, the inertial data are unusable
/// Beyond this fraction out of order, the gaps disturb integration.
constexpr double kLateImuMax = 0.01;

}  // namespace

void EventOutlet::push(const sensor::ImuSample& sample) {
  if (!window_.push(sample.t, sample)) ++late_imu_;
}

void EventOutlet::push(std::shared_ptr<const sensor::LidarScan> scan) {
  if (scan->size() == 0) {  // its time is unreliable without points
    ++empty_;
    ++empty_at_end_;
    return;
  }
  empty_at_end_ = 0;
  if (!any_scan_) empty_at_start_ = empty_;
  any_scan_ = true;
  const Time t = scan->t_end;
  if (!window_.push(t, std::move(scan))) ++late_scans_;
}

void EventOutlet::push(const sensor::RangeSample& sample) { ranges_.emplace(sample.t, sample); }

std::optional<vehicle::Event> EventOutlet::pop(InputReport& report) {
  const bool held = held_ || hold_next();
  if (!held && !finished_ && !past_end_) return std::nullopt;
  if (auto range = pop_range(report)) return range;
  if (!held) return std::nullopt;
  vehicle::Event event = std::move(held_->second);
  count(event, held_->first, report);
  held_.reset();
  return event;
}

bool EventOutlet::hold_next() {
  while (!past_end_) {
    auto next = window_.pop();
    if (!next) return false;
    const Time t = next->first;
    if (!t_first_) t_first_ = t;
    const double since_s = t.s() - t_first_->s();
    if (since_s < start_s_) continue;
    past_end_ = duration_s_ > 0.0 && since_s > start_s_ + duration_s_;
    if (past_end_) return false;
    held_ = std::move(next);
    return true;
  }
  return false;
}

std::optional<vehicle::Event> EventOutlet::pop_range(InputReport& report) {
  while (!ranges_.empty()) {
    const sensor::RangeSample sample = ranges_.begin()->second;
    const bool scan_held =
        held_ && std::holds_alternative<std::shared_ptr<const sensor::LidarScan>>(held_->second);
    const bool turn = !held_ || sample.t < held_->first || (scan_held && sample.t == held_->first);
    if (!turn) return std::nullopt;
    ranges_.erase(ranges_.begin());
    if (!is_in_time(sample.t)) continue;
    ++report.ranges;
    return sample;
  }
  return std::nullopt;
}

/// If the start is not cut, ranges before the first sensor event count, too.
bool EventOutlet::is_in_time(Time t) const {
  if (!t_first_) return false;
  const double since_s = t.s() - t_first_->s();
  return (start_s_ <= 0.0 || since_s >= start_s_) &&
         (duration_s_ <= 0.0 || since_s <= start_s_ + duration_s_);
}

void EventOutlet::count(const vehicle::Event& event, Time t, InputReport& report) {
  if (report.scans + report.imu_samples == 0) report.t_start = t;
  report.t_end = t;
  if (const auto* scan = std::get_if<std::shared_ptr<const sensor::LidarScan>>(&event)) {
    ++report.scans;
    if (report.imu_samples == imu_at_last_scan_) ++scans_without_imu_;
    imu_at_last_scan_ = report.imu_samples;
    scans_.see(t);
    report.gaps.nan_points += (*scan)->dropped_nan;
    if (!(*scan)->has_point_times && !(*scan)->deskewed) {
      report.gaps.no_time_points += (*scan)->size();
    }
  } else {
    ++report.imu_samples;
    imu_.see(t);
  }
  report.gaps.missing_s = scans_.missing_s();
  report.gaps.imu_missing_s = imu_.missing_s();
  report.gaps.late = window_.late();
}

/// Scans before the first or behind the last inertial sample are not in a gap between two samples.
void EventOutlet::close_imu(InputReport& report) const {
  if (!report.has_imu || report.scans == 0) return;
  const double fraction =
      static_cast<double>(scans_without_imu_) / static_cast<double>(report.scans);
  if (fraction < kWithoutImuMin) return;
  Finding f;
  f.id = "D10";
  f.vehicle = report.vehicle;
  f.topic = report.imu_topic;
  f.text = fmt::format("{} of {} scans have no inertial data: mapped with LiDAR alone there",
                       scans_without_imu_, report.scans);
  f.remedy = "See rali doctor.";
  f.value = fraction;
  f.limit = kWithoutImuMin;
  report.findings.push_back(std::move(f));
  report.gaps.imu_missing_s = std::max(report.gaps.imu_missing_s,
                                       static_cast<double>(scans_without_imu_) * scans_.period_s());
  report.gaps.damaged |= fraction > kWithoutImuMax;
}

void EventOutlet::close(InputReport& report) const {
  for (auto finding :
       {gap_finding(scans_, "D01", "scans"), gap_finding(imu_, "D10", "inertial data")}) {
    if (!finding) continue;
    finding->vehicle = report.vehicle;
    report.findings.push_back(std::move(*finding));
  }
  close_imu(report);
  close_late(report);
  close_empty(report);
}

void EventOutlet::close_late(InputReport& report) const {
  report.gaps.late = window_.late();
  report.gaps.late_scans = late_scans_;
  if (report.gaps.late == 0) return;
  const double imu_fraction =
      static_cast<double>(late_imu_) /
      static_cast<double>(std::max<std::uint64_t>(1, late_imu_ + report.imu_samples));
  report.gaps.damaged |= late_scans_ > 0 || imu_fraction > kLateImuMax;
  std::string what;
  if (late_scans_ > 0) {
    what = fmt::format("{} of {}", late_scans_, counted(late_scans_ + report.scans, "scan"));
  }
  if (late_imu_ > 0) {
    what += fmt::format("{}{} of {}", what.empty() ? "" : " and ", late_imu_,
                        counted(late_imu_ + report.imu_samples, "inertial sample"));
  }
  Finding f;
  f.id = "D19";
  f.vehicle = report.vehicle;
  f.text = what + " came more than 0.5 s out of order of time: left out";
  f.remedy = "Sort the recording by time and map it again.";
  f.value = static_cast<double>(report.gaps.late);
  report.findings.push_back(std::move(f));
}

/// The sensor saw nothing or its driver failed: the scan is lost like a damaged one.
void EventOutlet::close_empty(InputReport& report) const {
  // Scans before the requested time span do not count.
  const std::uint64_t at_start = start_s_ > 0.0 ? 0 : empty_at_start_;
  const std::uint64_t empty = empty_ - empty_at_start_ + at_start;
  report.gaps.empty_scans = empty;
  if (empty == 0) return;
  report.gaps.damaged = true;
  // Between two scans they already count as gaps.
  report.gaps.missing_s += static_cast<double>(at_start + empty_at_end_) * scans_.period_s();
  Finding f;
  f.id = "D05";
  f.vehicle = report.vehicle;
  f.topic = report.lidar_topic;
  f.text = fmt::format(
      "{} of {} hold no usable point (empty, NaN or beyond the range limits): "
      "missing like scans that never came",
      empty, counted(empty + report.scans, "scan"));
  f.remedy = "See rali doctor.";
  f.value = static_cast<double>(empty);
  report.findings.push_back(std::move(f));
}

}  // namespace rali::drive
