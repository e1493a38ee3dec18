#pragma once

#include <atomic>

namespace rali {

/// Asked now and then by long work: raised, nobody wants its result any more, and it ends soon with
/// whatever it has. By default it is never raised. The flag itself must outlive the work.
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
