#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"
#include "rali/drive/ranges/range_log.hpp"
#include "rali/drive/reported_source.hpp"
#include "rali/drive/state/fleet_facts.hpp"
#include "rali/drive/vehicle_run.hpp"
#include "rali/fleet/centre/estimate.hpp"

namespace rali::drive {

/// A vehicle's run rebuilt from the facts that it sent to the fleet instead of sensor data: a pose
/// at each node of its path, and the keyframes with their thinned points.

/// Transforms of the odom frames of a vehicle's starts into the odom frame of its results, by
/// epoch. Starts that are not connected to it are missing.
using StartFrames = std::map<std::uint32_t, geometry::SE3>;

/// The facts of a vehicle, as a source without events.
[[nodiscard]] std::unique_ptr<ReportedSource> fact_source(const FleetFacts& facts,
                                                          std::size_t member);

/// Chooses one frame for each vehicle: that of its first start in the largest group of vehicles;
/// among groups of equal size, the start with the longest path. Starts not connected to it are
/// removed from the estimate, with a Finding. The result has one frame per vehicle, as with
/// recordings.
/// @return by number of the vehicle; empty for one without a path
[[nodiscard]] std::vector<StartFrames> keep_one_frame_each(const FleetFacts& facts,
                                                           fleet::FleetEstimate& estimate,
                                                           FindingList& findings);

/// Adds the path of a vehicle to `run`. Errors: kMachine.
/// @param id of the vehicle, its index in `facts`
[[nodiscard]] Status fill_from_facts(const FleetFacts& facts, VehicleId id,
                                     const StartFrames& frames, VehicleRun& run);

/// Logs every range that a vehicle reported, with its use in the joint map, when the poses of the
/// runs are final. A consistent range that was not used because it is redundant is `not_needed`.
void log_fact_ranges(const FleetFacts& facts, const std::vector<VehicleRun>& runs,
                     const fleet::FleetEstimate& estimate, RangeLog& log);

/// Findings for vehicles with facts that are in no folder, and for vehicles without a fact.
[[nodiscard]] FindingList missing_findings(const FleetFacts& facts);

}  // namespace rali::drive
