#pragma once

#include "recording.hpp"

namespace rali::campaign {

/// Whether a good system can be expected to give a result without a gap. Derived from the case and
/// ground truth alone, before any run (docs/results.md states the rule in words).
struct Solvable {
  bool alone = true;  ///< no vehicle needs to get lost
  bool joint = true;  ///< all vehicles can be placed in one frame
};

[[nodiscard]] Solvable judge_solvable(const Recording& recording);

}  // namespace rali::campaign
