#include "rali/ranging/arrival_clock.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace rali::ranging {
namespace {

/// More messages than any radio sends in a window; beyond that only the hull itself is kept.
constexpr std::size_t kMaxPoints = 65536;
/// The hull is rebuilt whenever the points exceed the window by this fraction, not for every
/// message.
constexpr double kSlack = 0.125;

}  // namespace

Duration MillisecondCount::unwrap(std::uint32_t count_ms) {
  if (!last_ms_) {
    total_ms_ = count_ms;
  } else {
    // The difference modulo 2^32, read as a signed number, is right across the wrap.
    total_ms_ += static_cast<std::int32_t>(count_ms - *last_ms_);
  }
  last_ms_ = count_ms;
  return Duration::from_ns(total_ms_ * 1'000'000);
}

ArrivalClock::ArrivalClock(const ArrivalClockSettings& settings) : settings_(settings) {}

void ArrivalClock::start(Duration device, Time arrival) {
  if (started_) ++restarts_;
  started_ = true;
  device_0_ = device;
  arrival_0_ = arrival;
  points_.clear();
  hull_.clear();
  sum_x_s_ = level_s_ = slope_ = 0.0;
  late_ = 0;
}

ArrivalClock::Point ArrivalClock::point_of(Duration device, Time arrival) const {
  const Duration x = device - device_0_;
  return {x.s(), ((arrival - arrival_0_) - x).s()};
}

Time ArrivalClock::add(Duration device, Time arrival) {
  if (!started_) start(device, arrival);
  Point p = point_of(device, arrival);
  if (must_restart(p)) {
    start(device, arrival);
    p = point_of(device, arrival);
  }
  if (late_ == 0) {
    points_.push_back(p);
    sum_x_s_ += p.x_s;
    add_to_hull(p);
    forget_old();
    find_line();
  }
  return *host_time(device);
}

std::optional<Time> ArrivalClock::host_time(Duration device) const {
  if (!started_) return std::nullopt;
  const Duration x = device - device_0_;
  return arrival_0_ + x + Duration::from_s(offset_at(x.s()));
}

bool ArrivalClock::must_restart(const Point& p) {
  if (points_.empty()) return false;
  if (p.x_s < points_.back().x_s) return true;
  const double delay_s = p.y_s - offset_at(p.x_s);
  if (delay_s < -settings_.restart_s) return true;  // no message is early: the clock jumped
  late_ = delay_s > settings_.restart_s ? late_ + 1 : 0;
  return late_ >= settings_.restart_count;
}

void ArrivalClock::add_to_hull(const Point& p) {
  if (!hull_.empty() && hull_.back().x_s == p.x_s) {
    if (hull_.back().y_s <= p.y_s) return;
    hull_.pop_back();
  }
  const auto is_above = [&](const Point& a, const Point& b) {
    return (b.y_s - a.y_s) * (p.x_s - a.x_s) >= (p.y_s - a.y_s) * (b.x_s - a.x_s);
  };
  while (hull_.size() >= 2 && is_above(hull_[hull_.size() - 2], hull_.back())) hull_.pop_back();
  hull_.push_back(p);
}

void ArrivalClock::forget_old() {
  const double newest_s = points_.back().x_s;
  const bool too_long = newest_s - points_.front().x_s > (1.0 + kSlack) * settings_.window_s;
  const bool too_many = points_.size() > kMaxPoints;
  if (!too_long && !too_many) return;
  if (too_many) points_ = hull_;
  const auto is_old = [&](const Point& p) { return p.x_s < newest_s - settings_.window_s; };
  points_.erase(points_.begin(), std::find_if_not(points_.begin(), points_.end(), is_old));
  hull_.clear();
  sum_x_s_ = 0.0;
  for (const Point& p : points_) {
    sum_x_s_ += p.x_s;
    add_to_hull(p);
  }
}

void ArrivalClock::find_line() {
  const double steepest = settings_.slope_max_ppm * 1e-6;
  const double mean_x_s = sum_x_s_ / static_cast<double>(points_.size());
  slope_ = 0.0;
  for (std::size_t i = 1; i < hull_.size(); ++i) {
    const Point& a = hull_[i - 1];
    const Point& b = hull_[i];
    slope_ = std::clamp((b.y_s - a.y_s) / (b.x_s - a.x_s), -steepest, steepest);
    if (b.x_s >= mean_x_s) break;
  }
  // With its slope given, the line passes through the lowest point of the hull seen along it.
  level_s_ = hull_.front().y_s - slope_ * hull_.front().x_s;
  for (const Point& p : hull_) level_s_ = std::min(level_s_, p.y_s - slope_ * p.x_s);
}

}  // namespace rali::ranging
