#pragma once

#include <span>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/base/stop_flag.hpp"
#include "rali/fleet/centre/compared_pieces.hpp"
#include "rali/fleet/centre/fleet_settings.hpp"
#include "rali/fleet/centre/joint_graph.hpp"
#include "rali/fleet/centre/joint_ranges.hpp"
#include "rali/fleet/frames/frame_solver.hpp"

namespace rali::fleet {

/// A start pose that the scans contradict: it was left out of the evidence.
struct ContradictedStart {
  std::size_t relative_to = 0, path = 0;
  int comparisons = 0;
};

/// Frames of all paths, and the comparisons made for them.
struct FoundFrames {
  FrameSolver evidence;  ///< all but the ranges; not solved
  FrameSolver solver;
  std::vector<LoopFound> seen;  ///< matches without rival; some may be wrong
  std::size_t compared = 0;     ///< pairs of pieces
  std::vector<ContradictedStart> contradicted;
};

/// Determines the frames of all paths (algorithms_fleet 7): by ranges, by start poses, and by scan
/// comparisons where pieces of two paths are similar or a start pose predicts an overlap.
/// @param paths at least one, each with a node
/// @param compared in earlier solutions; null: none
/// @param stop if it is raised, the frames use only part of the evidence
[[nodiscard]] FoundFrames find_frames(std::span<const VehiclePath> paths,
                                      std::span<const PathSubmap> submaps,
                                      const JointRanges& ranges,
                                      const std::vector<StartPrior>& starts,
                                      const FleetSettings& settings, Executor& executor,
                                      ComparedPieces* compared = nullptr, StopFlag stop = {});

/// Solves for the frames by all evidence and ranges, as often as needed to join all that can be.
[[nodiscard]] FrameSolver solved(std::span<const VehiclePath> paths, const FrameSolver& evidence,
                                 const JointRanges& ranges, const InitSettings& settings,
                                 StopFlag stop = {});

}  // namespace rali::fleet
