#pragma once

#include <vector>

#include "rali/fleet/centre/settings.hpp"
#include "rali/fleet/path/vehicle_path.hpp"

namespace rali::fleet {

/// What the steps of a path let its nodes move against its first one, in the graph: of
/// geometry::boxplus in odom, one per node. Where a step is open nothing: the graph alone knows.
[[nodiscard]] std::vector<geometry::Mat6> shape_covariances(const VehiclePath& path,
                                                            const JointSettings& settings);

/// Covariance of a node in map. The graph ties nodes by steps of a given stiffness, which keep the
/// shape of the odometry's path, right or wrong; how wrong the odometry states. So the looseness of
/// the steps is taken out of what the graph states, and the odometry's own doubt put in its place.
/// @param of_graph  marginal of the node  @param of_steps  shape_covariances() of it, in map
/// @param of_map  what the odometry states of its own map, in map
[[nodiscard]] geometry::Mat6 joint_covariance(const geometry::Mat6& of_graph,
                                              const geometry::Mat6& of_steps,
                                              const geometry::Mat6& of_map);

}  // namespace rali::fleet
