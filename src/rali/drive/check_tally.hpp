#pragma once

#include <cstddef>

namespace rali::drive {

/// How much of a run the consistency checks covered, and what they found.
struct CheckTally {
  std::size_t keyframes = 0;
  std::size_t keyframes_checked = 0;  ///< with enough map walls in view to test it
  std::size_t contradictions = 0;     ///< findings `monitor.*`
};

}  // namespace rali::drive
