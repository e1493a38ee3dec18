#include "rali/base/assert.hpp"

#include <fmt/format.h>

#include "rali/base/internal_error.hpp"

namespace rali {

void assertion_failed(const char* expression, const char* file, int line) {
  throw InternalError(fmt::format("{}:{}: assertion '{}' failed", file, line, expression));
}

}  // namespace rali
