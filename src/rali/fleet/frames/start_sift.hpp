#pragma once

#include <cstddef>
#include <vector>

#include "rali/fleet/frames/frame_problem.hpp"

namespace rali::fleet {

/// Start of a refinement: values, and the accepted alternatives.
struct FrameStart {
  FrameValues values;
  std::vector<int> holds;  ///< per group of evidence
};

/// Selects from many starts those worth solving with all path errors. Each is first solved with
/// rigid paths, whose errors widen the ranges instead. Starts with the same resulting pose and
/// alternatives are merged. Kept are the best of every pose, cheapest first, then the second of
/// every pose and so on: so many starts of one pose do not displace a rival. In a tunnel a scan
/// comparison fits anywhere along it: hundreds of starts, one solution.
/// @param frame the frame whose pose distinguishes starts: that of the reference of group a
/// @return at most SearchSettings::starts_max; all, unchanged, if there are no more
[[nodiscard]] std::vector<FrameStart> sift_starts(const FrameProblem& problem,
                                                  std::vector<FrameStart> starts,
                                                  std::size_t frame);

}  // namespace rali::fleet
