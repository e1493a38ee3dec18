#pragma once

#include "rali/drive/vehicle_run.hpp"
#include "rali/fleet/centre/estimate.hpp"

namespace rali::drive {

/// A vehicle's frame in the fleet's joint estimate, and its keyframes in odom.
struct JointPath {
  geometry::SE3 T_map_local;
  KeyframeCorrections keyframes;  ///< empty: the vehicle is not part of the joint estimate
};

/// Identity and no keyframes for a vehicle that the estimate does not contain.
[[nodiscard]] JointPath joint_path(const fleet::FleetEstimate& estimate, VehicleId vehicle);

/// Gives a vehicle's run its frame and keyframes from the fleet's joint estimate; no effect if the
/// vehicle is not part of it.
void join_path(const fleet::FleetEstimate& estimate, VehicleId vehicle, VehicleRun& run);

/// If one vehicle knows gravity, the frame of all vehicles that share it counts as levelled.
void share_levels(const fleet::FleetEstimate& estimate, std::vector<VehicleRun>& runs);

/// Gives vehicles that reported no path a group of their own, with the reason.
void add_absent(std::size_t vehicles, fleet::FleetEstimate& estimate);

}  // namespace rali::drive
