#pragma once

#include <vector>

#include "rali/fleet/centre/settings.hpp"
#include "rali/fleet/path/vehicle_path.hpp"

namespace rali::fleet {

/// Covariance of the nodes relative to the first one that the stiffness of the steps allows in the
/// graph: of geometry::boxplus in odom, one per node. Unconstrained step directions add nothing,
/// because only the graph determines them.
[[nodiscard]] std::vector<geometry::Mat6> shape_covariances(const VehiclePath& path,
                                                            const JointSettings& settings);

/// Covariance of a node in map. The graph constrains nodes by steps of a fixed stiffness, which
/// keep the shape of the odometry's path whatever its error; only the odometry states that error.
/// So the covariance of the steps is removed from that of the graph and replaced by the odometry's.
/// @param of_graph  marginal of the node  @param of_steps  shape_covariances() of it, in map
/// @param of_map  the odometry's covariance of its own map, in map
[[nodiscard]] geometry::Mat6 joint_covariance(const geometry::Mat6& of_graph,
                                              const geometry::Mat6& of_steps,
                                              const geometry::Mat6& of_map);

}  // namespace rali::fleet
