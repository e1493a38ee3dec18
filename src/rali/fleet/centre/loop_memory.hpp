#pragma once

#include <map>
#include <set>
#include <utility>

#include "rali/fleet/facts/facts.hpp"

namespace rali::fleet {

/// Results of comparing pieces of paths so far: pieces are compared once, whatever solutions need
/// them.
struct LoopMemory {
  using Pair = std::pair<KeyframeId, KeyframeId>;  ///< middles of target and source

  std::set<Pair> compared;
  std::map<Pair, Loop> loops;  ///< those without rival; not tested yet
  std::set<Pair> of_frames;    ///< of the loops, those that determined the frames
};

}  // namespace rali::fleet
