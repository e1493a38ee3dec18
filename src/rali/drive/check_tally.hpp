#pragma once

#include <cstddef>

namespace rali::drive {

/// How much of a run its checks could look at, and what they found.
struct CheckTally {
  std::size_t keyframes = 0;
  std::size_t keyframes_checked = 0;  ///< with enough walls of the map in view to contradict it
  std::size_t contradictions = 0;     ///< findings `monitor.*`
};

}  // namespace rali::drive
