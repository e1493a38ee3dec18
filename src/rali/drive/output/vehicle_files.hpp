#pragma once

#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/drive/vehicle_run.hpp"

namespace rali::drive {

/// trajectory/<v>.tum and .cov.csv, degeneracy/<v>.csv. Errors: kMachine.
/// @param vehicles names by number
[[nodiscard]] Status write_vehicle_files(const VehicleRun& run, const std::string& out_dir,
                                         const std::vector<std::string>& vehicles);

/// keyframes.csv, graph.g2o, graph.pyfg, loops.csv. Errors: kMachine.
[[nodiscard]] Status write_fleet_files(const std::vector<VehicleRun>& runs,
                                       const fleet::FleetEstimate& estimate, const MapJob& job);

}  // namespace rali::drive
