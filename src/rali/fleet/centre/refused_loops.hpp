#pragma once

#include <span>
#include <vector>

#include "rali/fleet/centre/estimate.hpp"
#include "rali/fleet/facts/facts.hpp"
#include "rali/fleet/frames/frame_solver.hpp"
#include "rali/fleet/path/vehicle_path.hpp"

namespace rali::fleet {

/// Detects wrong frames, from a start pose or from ranges, by their loops. If frames are wrong,
/// every loop between the two vehicles contradicts them, and none agrees. If the place only
/// resembles others, some loop agrees. Loops that contradict without exception become evidence on
/// the frames, in competition with start poses and ranges.
/// @param loops as tested with the frames  @param evidence to which they are added
/// @return these loops
[[nodiscard]] std::vector<Loop> add_refused_loops(std::span<const VehiclePath> paths,
                                                  std::span<const LoopVerdict> loops,
                                                  const InitSettings& settings,
                                                  FrameSolver& evidence);

}  // namespace rali::fleet
