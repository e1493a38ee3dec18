#pragma once

#include "rali/fleet/node/events.hpp"
#include "rali/vehicle/event.hpp"

namespace rali::drive {

/// What a vehicle's part in the fleet needs of its pose.
/// @param levelled the direction of gravity is known
[[nodiscard]] fleet::OwnPose own_pose(const vehicle::PoseEstimate& pose, bool levelled);

}  // namespace rali::drive
