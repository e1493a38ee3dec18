#pragma once

#include <atomic>

namespace rali {

/// Polled by long computations. Once raised, the result is no longer needed and the computation
/// ends soon with what it has. By default it is never raised. The flag must outlive the
/// computation.
class StopFlag {
 public:
  StopFlag() = default;

  explicit StopFlag(const std::atomic<bool>& flag) : flag_(&flag) {}

  [[nodiscard]] bool raised() const {
    return flag_ != nullptr && flag_->load(std::memory_order_relaxed);
  }

 private:
  const std::atomic<bool>* flag_ = nullptr;
};

}  // namespace rali
