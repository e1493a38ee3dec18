#include "rali/fleet/centre/refused_loops.hpp"

#include <algorithm>
#include <utility>

#include "rali/fleet/centre/path_frames.hpp"
#include "rali/fleet/centre/scan_evidence.hpp"

namespace rali::fleet {

namespace {

/// The loops between two vehicles that their graph rejects; none if it accepts one of them.
std::vector<const LoopVerdict*> refused(std::span<const LoopVerdict> loops, VehicleId a,
                                        VehicleId b) {
  std::vector<const LoopVerdict*> out;
  for (const LoopVerdict& loop : loops) {
    if (std::minmax(loop.from.vehicle, loop.to.vehicle) != std::minmax(a, b)) continue;
    if (loop.accepted) return {};
    if (loop.reason == "veto") out.push_back(&loop);
  }
  return out;
}

}  // namespace

std::vector<Loop> add_refused_loops(std::span<const VehiclePath> paths,
                                    std::span<const LoopVerdict> loops,
                                    const InitSettings& settings, FrameSolver& evidence) {
  constexpr std::size_t kMin = 3;
  std::vector<Loop> out;
  for (std::size_t b = 0; b < paths.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      const auto between = refused(loops, paths[a].vehicle(), paths[b].vehicle());
      if (between.size() < kMin) continue;
      for (const LoopVerdict* loop : between) {
        const auto target = node_of(paths, loop->from), source = node_of(paths, loop->to);
        if (!target || !source) continue;
        evidence.add_evidence(evidence_between(paths, *target, *source, loop->T_from_to,
                                               loop->information, settings));
        out.push_back({.from = loop->from,
                       .to = loop->to,
                       .T_from_to = loop->T_from_to,
                       .information = loop->information,
                       .overlap = loop->score});
      }
    }
  }
  return out;
}

}  // namespace rali::fleet
