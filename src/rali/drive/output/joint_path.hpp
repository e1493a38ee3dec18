#pragma once

#include "rali/drive/vehicle_run.hpp"
#include "rali/fleet/centre/estimate.hpp"

namespace rali::drive {

/// Where the fleet's joint estimate has a vehicle's frame, and its keyframes in odom.
struct JointPath {
  geometry::SE3 T_map_local;
  KeyframeCorrections keyframes;  ///< empty: the estimate leaves the vehicle to itself
};

/// Identity and nothing for a vehicle that the estimate does not know.
[[nodiscard]] JointPath joint_path(const fleet::FleetEstimate& estimate, VehicleId vehicle);

/// Tells a vehicle where the fleet's joint estimate has its frame and its keyframes; nothing if the
/// estimate leaves the vehicle to itself.
void join_path(const fleet::FleetEstimate& estimate, VehicleId vehicle, VehicleRun& run);

/// One vehicle that knows gravity levels the frame of all that share it.
void share_levels(const fleet::FleetEstimate& estimate, std::vector<VehicleRun>& runs);

/// Gives vehicles that told nothing of a path a group of their own, with the reason.
void add_absent(std::size_t vehicles, fleet::FleetEstimate& estimate);

}  // namespace rali::drive
