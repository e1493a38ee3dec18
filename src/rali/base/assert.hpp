#pragma once

namespace rali {

/// Thrown by RALI_ASSERT: a bug in the program, never a user's mistake. It ends the program
/// with exit code 5; run_map() first writes into the output folder that it failed.
[[noreturn]] void assertion_failed(const char* expression, const char* file, int line);

}  // namespace rali

/// Checked in every build. For programming errors only; bad input is a Result.
#define RALI_ASSERT(expression) \
  ((expression) ? static_cast<void>(0) : ::rali::assertion_failed(#expression, __FILE__, __LINE__))

/// Checked in dev and sanitizer builds only: for hot loops.
#ifdef RALI_DEBUG_CHECKS
#define RALI_DASSERT(expression) RALI_ASSERT(expression)
#else
#define RALI_DASSERT(expression) static_cast<void>(0)
#endif
