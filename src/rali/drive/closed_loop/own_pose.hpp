#pragma once

#include "rali/fleet/node/events.hpp"
#include "rali/vehicle/event.hpp"

namespace rali::drive {

/// The part of a pose estimate that the vehicle's fleet node needs.
/// @param levelled the direction of gravity is known
[[nodiscard]] fleet::OwnPose own_pose(const vehicle::PoseEstimate& pose, bool levelled);

}  // namespace rali::drive
