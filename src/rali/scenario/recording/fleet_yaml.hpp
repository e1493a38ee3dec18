#pragma once

#include <string>
#include <vector>

#include "rali/scenario/recording/write_recording.hpp"
#include "rali/sim/fleet/fleet_simulation.hpp"

namespace rali::scenario {

/// fleet.yaml of a simulated recording: where the files are, and the calibration and the start
/// poses as a user would have measured them, off by their errors. config::load_fleet() takes it.
[[nodiscard]] std::string fleet_yaml(const sim::FleetSimulation& sim,
                                     const std::vector<std::string>& names,
                                     const RecordingOptions& options);

}  // namespace rali::scenario
