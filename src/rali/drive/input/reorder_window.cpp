#include "rali/drive/input/reorder_window.hpp"

#include <algorithm>
#include <utility>

namespace rali::drive {
namespace {

int rank_of(const vehicle::Event& event) {
  if (std::holds_alternative<sensor::ImuSample>(event)) return 0;
  if (std::holds_alternative<std::shared_ptr<const sensor::LidarScan>>(event)) return 2;
  return 1;
}

}  // namespace

bool ReorderWindow::push(Time t, vehicle::Event event) {
  // Older than the last event that left: it could only be delivered out of order.
  if (left_ && t < *left_) {
    ++late_;
    return false;
  }
  if (!newest_ || t > *newest_) newest_ = t;
  const int rank = rank_of(event);
  heap_.push_back({t, rank, order_++, std::move(event)});
  std::push_heap(heap_.begin(), heap_.end(), Later{});
  return true;
}

std::optional<std::pair<Time, vehicle::Event>> ReorderWindow::pop() {
  if (heap_.empty()) return std::nullopt;
  const Time oldest = heap_.front().t;
  // Differences of corrupt stamps may overflow: compared as doubles.
  const bool may_leave = finished_ || newest_->s() - oldest.s() >= window_.s();
  if (!may_leave) return std::nullopt;
  std::pop_heap(heap_.begin(), heap_.end(), Later{});
  Entry entry = std::move(heap_.back());
  heap_.pop_back();
  left_ = entry.t;
  return std::make_pair(entry.t, std::move(entry.event));
}

}  // namespace rali::drive
