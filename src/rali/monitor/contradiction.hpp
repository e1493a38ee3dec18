#pragma once

#include <vector>

#include "rali/base/time.hpp"

namespace rali::monitor {

struct Stretch {
  Time begin, end;
};

/// A time interval in which two estimates contradict each other, or a part of a long one.
struct Contradiction {
  Stretch when;
  double off_m = 0.0;     ///< largest distance between them
  double stated_m = 0.0;  ///< sigma of the checked one along that distance, where it is largest
};

using ContradictionList = std::vector<Contradiction>;

}  // namespace rali::monitor
