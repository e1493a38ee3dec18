#include "rali/drive/closed_loop/event_order.hpp"

#include <memory>
#include <utility>
#include <variant>

namespace rali::drive {
namespace {

constexpr int kImuRank = 0, kRangeRank = 1, kScanRank = 2, kRadioRank = 3;

}  // namespace

void EventOrder::put(Time t, int rank, sim::FleetMessage message) {
  const int vehicle = message.vehicle;
  due_.emplace(Key{t, rank, vehicle, order_++}, std::move(message));
}

void EventOrder::settle() {
  for (const ranging::PairedRange& range : paired_) {
    if (range.duplicate) continue;
    put(range.sample.t, kRangeRank, {static_cast<int>(range.sample.from.value), range.sample});
  }
  paired_.clear();
}

void EventOrder::add(const sim::FleetMessage& message) {
  if (const auto* imu = std::get_if<sensor::ImuSample>(&message.data)) {
    return put(imu->t, kImuRank, message);
  }
  if (const auto* range = std::get_if<sensor::RangeSample>(&message.data)) {
    pairer_.add(*range, paired_);
    return settle();
  }
  if (const auto* radio = std::get_if<sensor::RadioSample>(&message.data)) {
    return put(radio->t, kRadioRank, message);
  }
  const auto& scan = std::get<std::shared_ptr<const sensor::LidarScan>>(message.data);
  put(scan->t_end, kScanRank, message);
}

std::vector<sim::FleetMessage> EventOrder::take(Time now) {
  pairer_.release(now, paired_);
  settle();
  std::vector<sim::FleetMessage> out;
  const Time before = now - half_slot_;
  while (!due_.empty() && std::get<Time>(due_.begin()->first) < before) {
    out.push_back(std::move(due_.begin()->second));
    due_.erase(due_.begin());
  }
  return out;
}

}  // namespace rali::drive
