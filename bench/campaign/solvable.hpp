#pragma once

#include "recording.hpp"

namespace rali::campaign {

/// Whether a good system can be asked for a result without a gap. Decided from the case and the
/// truth alone, before any run (docs/results.md gives the rule in words).
struct Solvable {
  bool alone = true;  ///< each vehicle can go through without being lost
  bool joint = true;  ///< all vehicles can be put into one frame
};

[[nodiscard]] Solvable judge_solvable(const Recording& recording);

}  // namespace rali::campaign
