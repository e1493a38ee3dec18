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

/// A vehicle's run from the facts that it sent to the fleet, in place of its sensors' data: a pose
/// at each node of its path, the keyframes with their thinned points.

/// Where the odom frames of a vehicle's starts lie in the one that its results are kept in, by
/// epoch. Starts that are not joined to it are missing.
using StartFrames = std::map<std::uint32_t, geometry::SE3>;

/// What there is of a vehicle, as a source without events.
[[nodiscard]] std::unique_ptr<ReportedSource> fact_source(const FleetFacts& facts,
                                                          std::size_t member);

/// Chooses one frame for each vehicle: that of its first start in the largest group of vehicles,
/// of groups of one size the start with the longest path. Starts that are not joined to it leave
/// the estimate, with a Finding; what stays has one frame per vehicle, as that of recordings.
/// @return by number of the vehicle; empty for one without a path
[[nodiscard]] std::vector<StartFrames> keep_one_frame_each(const FleetFacts& facts,
                                                           fleet::FleetEstimate& estimate,
                                                           FindingList& findings);

/// Tells `run` the path of a vehicle. Errors: kMachine.
/// @param id of the vehicle, its place in `facts`
[[nodiscard]] Status fill_from_facts(const FleetFacts& facts, VehicleId id,
                                     const StartFrames& frames, VehicleRun& run);

/// Every range that a vehicle reported, with what the joint map made of it, when the poses of the
/// runs are final. One that fits and was not used, because others say the same, is `not_needed`.
void log_fact_ranges(const FleetFacts& facts, const std::vector<VehicleRun>& runs,
                     const fleet::FleetEstimate& estimate, RangeLog& log);

/// A vehicle some of whose facts are in no folder; a vehicle without a fact.
[[nodiscard]] FindingList missing_findings(const FleetFacts& facts);

}  // namespace rali::drive
