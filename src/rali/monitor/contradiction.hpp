#pragma once

#include <vector>

#include "rali/base/time.hpp"

namespace rali::monitor {

struct Stretch {
  Time begin, end;
};

/// A stretch of time in which two statements cannot both be true.
struct Contradiction {
  Stretch when;
  double off_m = 0.0;     ///< largest distance between them
  double stated_m = 0.0;  ///< sigma of the judged one along that distance, where it is largest
};

using ContradictionList = std::vector<Contradiction>;

/// Equal pieces of at most `longest_s`: a statement about half of a run helps nobody to find what
/// is wrong.
[[nodiscard]] std::vector<Stretch> cut(const Stretch& whole, double longest_s);

}  // namespace rali::monitor
