#pragma once

#include <memory>

#include "rali/base/executor.hpp"

namespace rali::drive {

/// The executor for this number of threads: SerialExecutor for 1, else blocks run in a TBB arena of
/// `threads`; 0 means one per core. Blocks and hence results are the same for all.
[[nodiscard]] std::unique_ptr<Executor> make_executor(int threads);

/// The number of threads that 0 means on this machine.
[[nodiscard]] int cores();

}  // namespace rali::drive
