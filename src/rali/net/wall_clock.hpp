#pragma once

#include <chrono>

#include "rali/base/time.hpp"

namespace rali::net {

/// UTC by the clock of this machine, common to stamps of sensors and arrivals.
[[nodiscard]] inline Time wall_now() {
  return Time::from_ns(std::chrono::duration_cast<std::chrono::nanoseconds>(
                           std::chrono::system_clock::now().time_since_epoch())
                           .count());
}

}  // namespace rali::net
