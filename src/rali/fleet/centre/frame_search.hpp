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

/// Frames of all paths, and what was compared on the way to them.
struct FoundFrames {
  FrameSolver evidence;  ///< all but the ranges; nothing is solved
  FrameSolver solver;
  std::vector<LoopFound> seen;  ///< recognised without rival; not all need be right
  std::size_t compared = 0;     ///< pairs of pieces
  std::vector<ContradictedStart> contradicted;
};

/// Looks for the frames of all paths (algorithms_fleet 7): by ranges, by start poses, and by what
/// scans say where pieces of two paths look alike or a start pose tells where to look.
/// @param paths at least one, each with a node
/// @param compared in earlier solutions; null: none
/// @param stop where it is raised, these are frames by part of the evidence
[[nodiscard]] FoundFrames find_frames(std::span<const VehiclePath> paths,
                                      std::span<const PathSubmap> submaps,
                                      const JointRanges& ranges,
                                      const std::vector<StartPrior>& starts,
                                      const FleetSettings& settings, Executor& executor,
                                      ComparedPieces* compared = nullptr, StopFlag stop = {});

/// Solves for the frames by all evidence and ranges, as often as it takes to join whoever can be.
[[nodiscard]] FrameSolver solved(std::span<const VehiclePath> paths, const FrameSolver& evidence,
                                 const JointRanges& ranges, const InitSettings& settings,
                                 StopFlag stop = {});

}  // namespace rali::fleet
