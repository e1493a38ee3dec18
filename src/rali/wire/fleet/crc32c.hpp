#pragma once

#include "rali/base/crc32c.hpp"

namespace rali::wire {

using rali::crc32c;

}  // namespace rali::wire
