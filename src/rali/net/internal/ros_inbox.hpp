#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <span>
#include <vector>

#include "rali/base/time.hpp"
#include "rali/net/ros_bus.hpp"

namespace rali::net {

/// Messages that arrived but were not taken: per subscription the newest, up to its depth.
class RosInbox {
 public:
  /// @return number of the new subscription
  [[nodiscard]] int add(int depth);

  /// Called by DDS threads. Out of memory counts as overflowed.
  void put(int subscription, Time t, std::span<const std::uint8_t> cdr) noexcept;

  [[nodiscard]] std::vector<RosMessage> take(Duration timeout);

  /// Adds arrived, arrived_bytes and overflowed.
  void add_counts(RosCounts& counts) const;

 private:
  struct Waiting {
    std::uint64_t order = 0;
    RosMessage message;
  };

  struct Queue {
    std::size_t depth = 0;
    std::deque<Waiting> waiting;
  };

  void push(int subscription, Time t, std::span<const std::uint8_t> cdr);

  mutable std::mutex mutex_;
  std::condition_variable arrived_;
  std::vector<Queue> queues_;
  std::size_t waiting_ = 0;
  std::uint64_t count_ = 0, bytes_ = 0, overflowed_ = 0;
};

}  // namespace rali::net
