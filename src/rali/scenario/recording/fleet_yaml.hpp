#pragma once

#include <string>
#include <vector>

#include "rali/scenario/recording/vehicle_recorder.hpp"
#include "rali/sim/fleet/fleet_simulation.hpp"

namespace rali::scenario {

/// fleet.yaml of a simulated recording: where the files are and the calibration as a user would
/// have measured it, off by its errors. config::load_fleet() takes it.
/// @param with_imu  false: the recordings have no inertial data
[[nodiscard]] std::string fleet_yaml(const sim::FleetSimulation& sim,
                                     const std::vector<std::string>& names, RecordingFormat format,
                                     sim::Lidar lidar, bool with_imu);

}  // namespace rali::scenario
