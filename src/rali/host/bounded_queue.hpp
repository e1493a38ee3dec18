#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <utility>
#include <vector>

#include "rali/base/time.hpp"

namespace rali::host {

/// Values that move from one thread to another. The producer never waits: a value beyond the bound
/// is refused and counted.
template <class T>
class BoundedQueue {
 public:
  explicit BoundedQueue(std::size_t max) : max_(max) {}

  /// @return false: refused
  bool put(T value) {
    {
      const std::lock_guard lock(mutex_);
      if (values_.size() >= max_) {
        ++refused_;
        return false;
      }
      values_.push_back(std::move(value));
      largest_ = values_.size() > largest_ ? values_.size() : largest_;
    }
    arrived_.notify_one();
    return true;
  }

  /// All values in order; waits at most `timeout` for the first.
  [[nodiscard]] std::vector<T> take(Duration timeout = {}) {
    std::unique_lock lock(mutex_);
    if (values_.empty() && timeout.ns > 0) {
      arrived_.wait_for(lock, std::chrono::nanoseconds(timeout.ns),
                        [this] { return !values_.empty(); });
    }
    return std::exchange(values_, {});
  }

  [[nodiscard]] std::uint64_t refused() const {
    const std::lock_guard lock(mutex_);
    return refused_;
  }

  [[nodiscard]] std::size_t size() const {
    const std::lock_guard lock(mutex_);
    return values_.size();
  }

  /// The largest number of waiting values so far.
  [[nodiscard]] std::size_t largest() const {
    const std::lock_guard lock(mutex_);
    return largest_;
  }

 private:
  std::size_t max_;
  mutable std::mutex mutex_;
  std::condition_variable arrived_;
  std::vector<T> values_;
  std::uint64_t refused_ = 0;
  std::size_t largest_ = 0;
};

}  // namespace rali::host
