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
#include "rali/fleet/messages/separator_prior.hpp"

namespace rali::fleet {

/// Input of one solution.
struct SolutionInput {
  std::span<const VehiclePath> paths;  ///< each with a node
  const FleetKnowledge& knowledge;
  const FleetSettings& settings;
  LoopMemory* memory = nullptr;            ///< of earlier solutions; null: none
  ComparedPieces* compared = nullptr;      ///< for the frames in earlier solutions; null: none
  std::vector<PathSubmap> pieces = {};     ///< of path, already cut
  std::vector<std::size_t> cut_from = {};  ///< node where cutting continues; empty: each path's
                                           ///< start
  std::optional<PathFrames> frames = {};   ///< of an earlier solution; nothing: to be determined
  const SeparatorPrior* before = nullptr;  ///< of all paths: only later nodes are solved for
  std::vector<Time> ends = {};             ///< of rounds, ascending: a separator prior is made at
                                           ///< each
  StopFlag stop = {};
};

/// If the flag was raised meanwhile, only the pieces are valid.
struct Solution {
  FleetEstimate estimate;  ///< after a separator: only its later keyframes
  PathFrames frames;
  std::vector<PathSubmap> pieces;          ///< all; those before the separator first
  std::size_t live_from = 0;               ///< number of pieces before the separator
  std::vector<SeparatorPrior> boundaries;  ///< of group 0, at the requested times
  std::size_t cut = 0, compared = 0;       ///< pieces that are new, and pairs of pieces
};

/// Joins the frames, searches loops and solves. A pure function of its input.
[[nodiscard]] Solution solve_fleet(SolutionInput input, Executor& executor);

}  // namespace rali::fleet
