#pragma once

#include <cstddef>
#include <functional>

namespace rali {

/// Runs a loop in blocks that do not depend on the number of threads. Callers that sum keep one
/// partial result per block and add them in block order, so results do not depend on scheduling.
class Executor {
 public:
  virtual ~Executor() = default;

  /// Calls f(block_index, begin, end) for each block of `block` items of [0, n). Blocks may run
  /// at the same time; returns when all are done.
  virtual void for_blocks(
      std::size_t n, std::size_t block,
      const std::function<void(std::size_t index, std::size_t begin, std::size_t end)>& f) = 0;
};

/// One thread, in order.
class SerialExecutor final : public Executor {
 public:
  void for_blocks(std::size_t n, std::size_t block,
                  const std::function<void(std::size_t, std::size_t, std::size_t)>& f) override {
    for (std::size_t begin = 0, index = 0; begin < n; begin += block, ++index) {
      f(index, begin, begin + block < n ? begin + block : n);
    }
  }
};

}  // namespace rali
