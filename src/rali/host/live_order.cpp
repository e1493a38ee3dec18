#include "rali/host/live_order.hpp"

#include <algorithm>
#include <utility>
#include <variant>

namespace rali::host {
namespace {

constexpr int kImuRank = 0, kRangeRank = 1, kScanRank = 2;

/// Scans jitter: the next scan does not end within this fraction of the usual step.
constexpr double kSureFraction = 0.8;

/// Weight of a longer step in the period, so that it adapts to a changed rate.
constexpr double kForget = 0.05;

Duration scaled(Duration d, double factor) {
  return Duration::from_ns(static_cast<std::int64_t>(static_cast<double>(d.ns) * factor));
}

}  // namespace

void LiveOrder::put(Time t, int rank, vehicle::Event event) {
  due_.emplace(Key{t, rank, order_++}, LiveEvent{std::move(event), arrival_});
}

void LiveOrder::push(const sensor::ImuSample& sample) {
  if (left_imu_ && sample.t <= *left_imu_) {
    ++tally_.late_imu;
    return;
  }
  newest_imu_ = newest_imu_ ? std::max(*newest_imu_, sample.t) : sample.t;
  put(sample.t, kImuRank, sample);
  pairer_.release(*newest_imu_, paired_);
  settle();
}

void LiveOrder::push(std::shared_ptr<const sensor::LidarScan> scan) {
  if (scan->size() == 0) {
    ++tally_.empty_scans;
    return;
  }
  const Time t = scan->t_end;
  if (left_scan_ && t <= *left_scan_) {
    ++tally_.late_scans;
    return;
  }
  if (newest_scan_ && t > *newest_scan_) {
    const Duration step = t - *newest_scan_;
    const bool slower = period_ && step > *period_;
    period_ = slower ? *period_ + scaled(step - *period_, kForget) : step;
  }
  newest_scan_ = newest_scan_ ? std::max(*newest_scan_, t) : t;
  put(t, kScanRank, std::move(scan));
  ++scans_;
  drop_scans();
  pairer_.release(t, paired_);
  settle();
}

/// The odometry continues with new scans: a gap in the map is better than an outdated pose.
void LiveOrder::drop_scans() {
  for (auto it = due_.begin(); it != due_.end() && scans_ > settings_.scans_max;) {
    if (std::get<int>(it->first) != kScanRank) {
      ++it;
      continue;
    }
    it = due_.erase(it);
    --scans_;
    ++tally_.dropped_scans;
  }
}

void LiveOrder::push(const sensor::RangeSample& sample) {
  pairer_.add(sample, paired_);
  settle();
}

void LiveOrder::settle() {
  for (const ranging::PairedRange& range : paired_) {
    if (range.duplicate) {
      ++tally_.repeated_ranges;
    } else {
      put(range.sample.t, kRangeRank, range.sample);
    }
  }
  paired_.clear();
}

bool LiveOrder::is_turn(const Key& key) const {
  const Time t = std::get<Time>(key);
  if (std::get<int>(key) == kScanRank) {
    return !settings_.has_imu || (newest_imu_ && *newest_imu_ >= t);
  }
  if (!newest_scan_) return false;
  if (t <= *newest_scan_) return true;
  return period_ && t <= *newest_scan_ + scaled(*period_, kSureFraction);
}

Time LiveOrder::deadline(const Key& key, const LiveEvent& event) const {
  const bool scan = std::get<int>(key) == kScanRank;
  return event.arrival + (scan ? settings_.imu_wait : settings_.scan_wait);
}

void LiveOrder::take(Time now, std::vector<LiveEvent>& out) {
  while (!due_.empty()) {
    const auto first = due_.begin();
    if (!is_turn(first->first)) {
      if (now < deadline(first->first, first->second)) return;
      ++tally_.forced;
    }
    const Time t = std::get<Time>(first->first);
    if (std::get<int>(first->first) == kScanRank) {
      left_scan_ = t;
      --scans_;
    } else if (std::get<int>(first->first) == kImuRank) {
      left_imu_ = t;
    }
    out.push_back(std::move(first->second));
    due_.erase(first);
  }
}

std::optional<Time> LiveOrder::due() const {
  if (due_.empty()) return std::nullopt;
  const auto& [key, event] = *due_.begin();
  return is_turn(key) ? event.arrival : deadline(key, event);
}

}  // namespace rali::host
