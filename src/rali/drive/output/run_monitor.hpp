#pragma once

#include <string>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"
#include "rali/drive/check_tally.hpp"
#include "rali/drive/vehicle_run.hpp"
#include "rali/fleet/centre/estimate.hpp"
#include "rali/map/build_map.hpp"

namespace rali::drive {

/// Results of the checks of a finished run.
struct MonitorResult {
  FindingList findings;
  CheckTally tally;
  /// Vehicles whose final poses were given larger covariances: their files must be written again.
  std::vector<VehicleId> widened;
  bool map_contradicts_itself = false;
};

/// Checks a run with final poses by methods that do not share the estimator's assumptions (room
/// monitor): odometry and live poses against the final path, and each keyframe's rays against the
/// walls of its group's map. Inflates the covariances of the final poses in contradicted stretches.
/// @param looks of the keyframes of the mapped group; those of other groups are computed here
/// Errors: kMachine.
[[nodiscard]] Result<MonitorResult> monitor_run(std::vector<VehicleRun>& runs,
                                                const fleet::FleetEstimate& estimate,
                                                const std::vector<map::KeyframeLooks>& looks,
                                                const MapJob& job, Executor& executor);

}  // namespace rali::drive
