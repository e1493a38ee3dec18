#pragma once

#include <optional>
#include <span>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/fleet/centre/estimate.hpp"
#include "rali/fleet/centre/fleet_settings.hpp"
#include "rali/fleet/centre/joint_graph.hpp"
#include "rali/fleet/centre/path_frames.hpp"

namespace rali::fleet {

/// All that is known of a fleet when its groups are solved.
struct GroupInput {
  std::span<const VehiclePath> paths;
  std::span<const PathSubmap> submaps;
  const PathFrames& frames;
  const JointRanges& ranges;
  const std::vector<StartPrior>& starts;
  std::vector<std::optional<double>> bias_m;  ///< per pair of antennas, where measured
  const FleetSettings& settings;
};

/// Solves for the paths of one group, looks for places that its vehicles saw twice, solves again,
/// and adds what came out. A vehicle alone is left as it is unless a loop was closed.
void estimate_group(const GroupInput& input, std::size_t group, Executor& executor,
                    FleetEstimate& out);

}  // namespace rali::fleet
