#include "rali/host/host_clock.hpp"

#include <ctime>

#include "rali/net/wall_clock.hpp"

namespace rali::host {

HostTime host_now() {
  timespec boot{};
  clock_gettime(CLOCK_BOOTTIME, &boot);
  constexpr std::int64_t kNsPerS = 1'000'000'000;
  return {Time::from_ns(static_cast<std::int64_t>(boot.tv_sec) * kNsPerS + boot.tv_nsec),
          net::wall_now()};
}

}  // namespace rali::host
