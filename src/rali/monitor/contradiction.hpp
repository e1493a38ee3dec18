#pragma once

#include <vector>

#include "rali/base/time.hpp"

namespace rali::monitor {

struct Stretch {
  Time begin, end;
};

/// A time interval in which two estimates contradict each other.
struct Contradiction {
  Stretch when;
  double off_m = 0.0;     ///< largest distance between them
  double stated_m = 0.0;  ///< sigma of the checked one along that distance, where it is largest
};

using ContradictionList = std::vector<Contradiction>;

/// Equal parts of at most `longest_s`: an interval of half a run would not help to find the cause.
[[nodiscard]] std::vector<Stretch> cut(const Stretch& whole, double longest_s);

}  // namespace rali::monitor
