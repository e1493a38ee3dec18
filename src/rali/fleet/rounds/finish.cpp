#include "rali/fleet/rounds/finish.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace rali::fleet {
namespace {

constexpr double kRangeFresh_s = 2.0;  ///< a range is preferred to the estimates for this time
constexpr std::size_t kRadioMin = 3;   ///< one weak packet alone does not count
constexpr std::size_t kRadioMax = 2000;
constexpr double kSureAgain = 0.8;  ///< of max_sigma_m, to clear the condition

bool is_number(const std::optional<double>& v) { return v && std::isfinite(*v); }

}  // namespace

bool forbids_driving(FinishReason reason) {
  return reason != FinishReason::kNone && reason != FinishReason::kExplored &&
         reason != FinishReason::kUnreachable;
}

void FinishWatch::new_round(Time t) {
  const FinishSettings settings = settings_;
  *this = FinishWatch(settings);
  last_ = t;
  has_time_ = true;
}

FinishView FinishWatch::step(const FinishInput& input) {
  FinishView view;
  view.reason = latch_;
  view.latched = latch_ != FinishReason::kNone;
  if (has_time_ && input.t < last_) return view;
  last_ = input.t;
  has_time_ = true;
  take_radio(input);
  take_range(input);
  if (latch_ == FinishReason::kNone) latch_ = latching(input);
  const FinishReason passing = clearing(input, view);
  view.reason = latch_ != FinishReason::kNone ? latch_ : passing;
  view.latched = latch_ != FinishReason::kNone;
  const auto rssi = rssi_median_dbm();
  const auto far = distance_m(input);
  view.warn = (rssi && *rssi < settings_.rssi_stop_dbm + settings_.warn_rssi_db) ||
              (far && *far > settings_.warn_from_m());
  return view;
}

void FinishWatch::take_radio(const FinishInput& input) {
  const bool counts = is_number(input.rssi_dbm) && !input.comes_from_afar;
  if (counts) rssi_dbm_.emplace_back(input.t, *input.rssi_dbm);
  while (!rssi_dbm_.empty() &&
         (seconds_between(rssi_dbm_.front().first, input.t) > settings_.rssi_window_s ||
          rssi_dbm_.size() > kRadioMax)) {
    rssi_dbm_.pop_front();
  }
}

void FinishWatch::take_range(const FinishInput& input) {
  if (!is_number(input.range_m)) return;
  range_m_ = {input.t, *input.range_m};
  unheard_since_.reset();
  back_since_.reset();
}

std::optional<double> FinishWatch::rssi_median_dbm() const {
  if (rssi_dbm_.size() < kRadioMin) return std::nullopt;
  std::vector<double> values;
  for (const auto& [t, dbm] : rssi_dbm_) values.push_back(dbm);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::optional<double> FinishWatch::apart_m(const FinishInput& input) const {
  if (is_number(input.range_m)) return input.range_m;
  if (range_m_ && seconds_between(range_m_->first, input.t) < kRangeFresh_s) {
    return range_m_->second;
  }
  return is_number(input.distance_m) ? input.distance_m : std::nullopt;
}

std::optional<double> FinishWatch::distance_m(const FinishInput& input) const {
  return input.comes_from_afar ? std::nullopt : apart_m(input);
}

FinishReason FinishWatch::latching(const FinishInput& input) {
  const auto rssi = rssi_median_dbm();
  const auto far = distance_m(input);
  if (input.operator_stop) return FinishReason::kOperator;
  if (input.timeout) return FinishReason::kTimeout;
  if (rssi && *rssi < settings_.rssi_stop_dbm) return FinishReason::kSignal;
  if (far && *far > settings_.max_distance_m) return FinishReason::kDistance;
  if (settings_.rule == FinishRule::kPaper) return FinishReason::kNone;
  if (is_number(input.battery_fraction) && *input.battery_fraction < settings_.battery_min) {
    return FinishReason::kBattery;
  }
  return FinishReason::kNone;
}

FinishReason FinishWatch::clearing(const FinishInput& input, FinishView& view) {
  if (input.frontier_left) {
    if (*input.frontier_left) explored_since_.reset();
    if (!*input.frontier_left && !explored_since_) explored_since_ = input.t;
    beyond_ = input.frontier_beyond;
  }
  const bool explored =
      explored_since_ && seconds_between(*explored_since_, input.t) >= settings_.explored_hold_s;
  if (explored) return beyond_ ? FinishReason::kUnreachable : FinishReason::kExplored;
  if (settings_.rule == FinishRule::kPaper) return FinishReason::kNone;
  if (ranges_are_lost(input, view)) return FinishReason::kRangeLost;
  unsure_ = is_unsure(input);
  return unsure_ ? FinishReason::kSigma : FinishReason::kNone;
}

bool FinishWatch::is_unsure(const FinishInput& input) {
  if (!std::isfinite(input.sigma_m)) return unsure_;
  min_sigma_m_ = std::min(min_sigma_m_, input.sigma_m);
  const double grown_m2 = input.sigma_m * input.sigma_m - min_sigma_m_ * min_sigma_m_;
  const double limit_m = settings_.max_sigma_m * (unsure_ ? kSureAgain : 1.0);
  const auto far_m = distance_m(input);
  const bool beside = far_m && *far_m < settings_.sigma_beyond_m;
  return input.degenerate && !beside && grown_m2 > limit_m * limit_m;
}

bool FinishWatch::ranges_are_lost(const FinishInput& input, FinishView& view) {
  if (!back_since_) {
    if (!input.degenerate || !input.moves) unheard_since_.reset();
    if (input.degenerate && input.moves && !unheard_since_) unheard_since_ = input.t;
    const bool lost =
        unheard_since_ && seconds_between(*unheard_since_, input.t) >= settings_.range_lost_s;
    if (lost) back_since_ = input.t;
  }
  if (!back_since_) return false;
  // First it drives back; it has finished only if it stops and still receives no range.
  const bool tried = seconds_between(*back_since_, input.t) >= settings_.range_lost_s;
  const bool given_up = tried && !input.moves;
  view.drive_back = !given_up;
  return given_up;
}

}  // namespace rali::fleet
