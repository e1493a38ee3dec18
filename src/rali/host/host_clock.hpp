#pragma once

#include "rali/base/time.hpp"

namespace rali::host {

/// The same moment on two clocks.
struct HostTime {
  Time boot;  ///< since the machine started; goes on in suspend: leases run on it
  Time wall;  ///< UTC
};

/// CLOCK_BOOTTIME and UTC of this moment.
[[nodiscard]] HostTime host_now();

}  // namespace rali::host
