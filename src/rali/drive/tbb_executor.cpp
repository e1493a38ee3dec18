#include "rali/drive/tbb_executor.hpp"

#include <algorithm>
#include <thread>

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace rali::drive {
namespace {

class TbbExecutor final : public Executor {
 public:
  explicit TbbExecutor(int threads)
      : limit_(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads)),
        arena_(threads) {}

  void for_blocks(std::size_t n, std::size_t block,
                  const std::function<void(std::size_t, std::size_t, std::size_t)>& f) override {
    const std::size_t blocks = (n + block - 1) / block;
    if (blocks <= 1) {
      if (blocks == 1) f(0, 0, n);
      return;
    }
    arena_.execute([&] {
      tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t index) {
        f(index, index * block, std::min(n, (index + 1) * block));
      });
    });
  }

 private:
  tbb::global_control limit_;  ///< required for more threads than cores
  tbb::task_arena arena_;
};

}  // namespace

int cores() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

std::unique_ptr<Executor> make_executor(int threads) {
  const int n = threads > 0 ? threads : cores();
  if (n == 1) return std::make_unique<SerialExecutor>();
  return std::make_unique<TbbExecutor>(n);
}

}  // namespace rali::drive
