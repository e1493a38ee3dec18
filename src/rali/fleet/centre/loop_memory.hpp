#pragma once

#include <map>
#include <set>
#include <utility>

#include "rali/fleet/facts/facts.hpp"

namespace rali::fleet {

/// What comparing pieces of path has brought so far: pieces are compared once, in whatever solution
/// they come up.
struct LoopMemory {
  using Pair = std::pair<KeyframeId, KeyframeId>;  ///< middles of target and source

  std::set<Pair> compared;
  std::map<Pair, Loop> loops;  ///< those without rival; nobody has judged them yet
  std::set<Pair> of_frames;    ///< of the loops, those that the frames rest on
};

}  // namespace rali::fleet
