#pragma once

#include <cstddef>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"
#include "rali/drive/vehicle_run.hpp"

namespace rali::drive {

struct MapNumbers {
  std::size_t points = 0;
  std::size_t removed = 0;
  double thickness_m = 0.0;
};

/// Renders the map of vehicles that share a frame from their keyframes on disk and writes map.*,
/// removed.pcd, map_2d.pgm and map_2d.yaml. Errors: kMachine.
[[nodiscard]] Result<MapNumbers> write_map_files(const std::vector<const VehicleRun*>& runs,
                                                 const MapJob& job, Executor& executor,
                                                 FindingList& findings);

}  // namespace rali::drive
