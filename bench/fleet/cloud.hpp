#pragma once

#include "join.hpp"
#include "rali/eval/cloud_to_mesh.hpp"

namespace rali::fleet_bench {

/// Distances of the merged map of the largest group to the surfaces of the world. The map is built
/// as by `rali map` and aligned to the world by the trajectories, then by its own points.
/// Errors: of map::build_map() and eval::align_to_mesh().
[[nodiscard]] Result<eval::CloudToMesh> compare_cloud(const Mission& mission, const Joined& joined,
                                                      const sim::TriangleMesh& world);

}  // namespace rali::fleet_bench
