#pragma once

#include <span>
#include <vector>

#include "rali/fleet/centre/estimate.hpp"
#include "rali/fleet/facts/facts.hpp"
#include "rali/fleet/frames/frame_solver.hpp"
#include "rali/fleet/path/vehicle_path.hpp"

namespace rali::fleet {

/// Wrong frames, be they of a start pose or of ranges, show in their loops: what two vehicles saw
/// of one place refuses to lie where the frames put it, every time, and nothing lies there. Where a
/// place is one of many alike, some does. Such loops become evidence on the frames, against which
/// start poses and ranges have to stand.
/// @param loops as judged with the frames  @param evidence to which they are added
/// @return these loops
[[nodiscard]] std::vector<Loop> add_refused_loops(std::span<const VehiclePath> paths,
                                                  std::span<const LoopVerdict> loops,
                                                  const InitSettings& settings,
                                                  FrameSolver& evidence);

}  // namespace rali::fleet
