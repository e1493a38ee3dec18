#pragma once

#include <span>

#include "rali/fleet/centre/estimate.hpp"
#include "rali/fleet/centre/joint_graph.hpp"
#include "rali/fleet/frames/settings.hpp"

namespace rali::fleet {

/// How far a start pose is off frames.
[[nodiscard]] RejectedStart off_start(std::span<const VehiclePath> paths, const StartPrior& start,
                                      const geometry::SE3& T_map_odom_relative,
                                      const geometry::SE3& T_map_odom_path);

/// By more than its own sigmas permit (PriorSettings::wrong_chi2).
[[nodiscard]] bool contradicts(const StartPrior& start, const RejectedStart& off,
                               const PriorSettings& settings);

}  // namespace rali::fleet
