#pragma once

#include <optional>
#include <span>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/base/stop_flag.hpp"
#include "rali/fleet/centre/compared_pieces.hpp"
#include "rali/fleet/centre/estimate.hpp"
#include "rali/fleet/centre/fleet_settings.hpp"
#include "rali/fleet/centre/knowledge.hpp"
#include "rali/fleet/centre/loop_memory.hpp"
#include "rali/fleet/centre/path_frames.hpp"
#include "rali/fleet/messages/boundary.hpp"

namespace rali::fleet {

/// What one solution is made of.
struct SolutionInput {
  std::span<const VehiclePath> paths;  ///< each with a node
  const FleetKnowledge& knowledge;
  const FleetSettings& settings;
  LoopMemory* memory = nullptr;            ///< of earlier solutions; null: none
  ComparedPieces* compared = nullptr;      ///< for the frames in earlier solutions; null: none
  std::vector<PathSubmap> pieces = {};     ///< of path, already cut
  std::vector<std::size_t> cut_from = {};  ///< node where the cut goes on; empty: each path's begin
  std::optional<PathFrames> frames = {};   ///< of an earlier solution; nothing: to be found
  const RoundBoundary* before = nullptr;   ///< of all paths: only what comes after it is solved for
  std::vector<Time> ends = {};             ///< of rounds, growing: a boundary is made at each
  StopFlag stop = {};
};

/// Where the flag was raised meanwhile, only the pieces are of use.
struct Solution {
  FleetEstimate estimate;  ///< after a boundary: its later keyframes alone
  PathFrames frames;
  std::vector<PathSubmap> pieces;         ///< all; those before the boundary first
  std::size_t live_from = 0;              ///< how many of them are before the boundary
  std::vector<RoundBoundary> boundaries;  ///< of group 0, those that were asked for
  std::size_t cut = 0, compared = 0;      ///< pieces that are new, and pairs of pieces
};

/// Joins the frames, looks for loops and solves. A pure function of its input.
[[nodiscard]] Solution solve_fleet(SolutionInput input, Executor& executor);

}  // namespace rali::fleet
