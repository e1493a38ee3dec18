#pragma once

#include <cstddef>
#include <vector>

#include "rali/fleet/frames/frame_problem.hpp"

namespace rali::fleet {

/// Where a refinement begins: values, and the alternatives held for true.
struct FrameStart {
  FrameValues values;
  std::vector<int> holds;  ///< per group of evidence
};

/// Of many starts those that are worth solving with all errors of the paths: each is solved with
/// rigid paths first, whose errors widen the ranges instead. What comes to the same place with the
/// same alternatives is one. Kept are the best of every place, cheapest first, then the second of
/// every place and so on: however many say the same, a rival elsewhere is not crowded out.
/// In a tunnel a comparison of scans fits anywhere along it: hundreds of starts, one answer.
/// @param frame the frame whose place tells starts apart: that of the reference of group a
/// @return at most SearchSettings::starts_max; all, as they are, if there are no more
[[nodiscard]] std::vector<FrameStart> sift_starts(const FrameProblem& problem,
                                                  std::vector<FrameStart> starts,
                                                  std::size_t frame);

}  // namespace rali::fleet
