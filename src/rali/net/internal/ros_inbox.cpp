#include "rali/net/internal/ros_inbox.hpp"

#include <algorithm>
#include <chrono>
#include <new>
#include <utility>

namespace rali::net {

int RosInbox::add(int depth) {
  const std::lock_guard lock(mutex_);
  queues_.push_back({static_cast<std::size_t>(std::max(depth, 1)), {}});
  return static_cast<int>(queues_.size()) - 1;
}

void RosInbox::put(int subscription, Time t, std::span<const std::uint8_t> cdr) noexcept {
  const std::lock_guard lock(mutex_);
  ++count_;
  bytes_ += cdr.size();
  try {
    push(subscription, t, cdr);
  } catch (const std::bad_alloc&) {
    ++overflowed_;
    return;
  }
  arrived_.notify_one();
}

void RosInbox::push(int subscription, Time t, std::span<const std::uint8_t> cdr) {
  Queue& queue = queues_[static_cast<std::size_t>(subscription)];
  queue.waiting.push_back({count_, {subscription, t, {cdr.begin(), cdr.end()}}});
  ++waiting_;
  if (queue.waiting.size() <= queue.depth) return;
  queue.waiting.pop_front();
  --waiting_;
  ++overflowed_;
}

std::vector<RosMessage> RosInbox::take(Duration timeout) {
  std::vector<Waiting> taken;
  {
    std::unique_lock lock(mutex_);
    arrived_.wait_for(lock, std::chrono::nanoseconds(timeout.ns), [&] { return waiting_ > 0; });
    taken.reserve(waiting_);
    for (Queue& queue : queues_) {
      std::move(queue.waiting.begin(), queue.waiting.end(), std::back_inserter(taken));
      queue.waiting.clear();
    }
    waiting_ = 0;
  }
  std::sort(taken.begin(), taken.end(),
            [](const Waiting& a, const Waiting& b) { return a.order < b.order; });
  std::vector<RosMessage> out;
  out.reserve(taken.size());
  for (Waiting& waiting : taken) out.push_back(std::move(waiting.message));
  return out;
}

void RosInbox::add_counts(RosCounts& counts) const {
  const std::lock_guard lock(mutex_);
  counts.arrived += count_;
  counts.arrived_bytes += bytes_;
  counts.overflowed += overflowed_;
}

}  // namespace rali::net
