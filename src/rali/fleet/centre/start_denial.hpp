#pragma once

#include <span>
#include <vector>

#include "rali/fleet/centre/estimate.hpp"
#include "rali/fleet/centre/joint_graph.hpp"
#include "rali/fleet/frames/frame_solver.hpp"
#include "rali/fleet/path/vehicle_path.hpp"

namespace rali::fleet {

/// A wrong start pose shows in its loops: what two vehicles saw of one place refuses to lie where
/// the start pose puts it, every time, and nothing lies there. Where a place is one of many alike,
/// some does. Such loops become evidence on the frames, against which the start pose has to stand.
/// @param loops as judged with the start poses  @param evidence to which they are added
/// @return these loops
[[nodiscard]] std::vector<Loop> add_denials(std::span<const VehiclePath> paths,
                                            const std::vector<StartPrior>& starts,
                                            std::span<const LoopVerdict> loops,
                                            const InitSettings& settings, FrameSolver& evidence);

}  // namespace rali::fleet
