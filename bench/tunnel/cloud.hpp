#pragma once

#include "rali/eval/cloud_to_mesh.hpp"
#include "run.hpp"

namespace rali::tunnel {

/// Distances of the map's points to the surfaces of the world. The map is made as `rali map` makes
/// it, from the smoothed keyframes, and laid onto the world by the path, then by its own points.
/// Errors: of map::build_map() and eval::align_to_mesh().
[[nodiscard]] Result<eval::CloudToMesh> compare_cloud(const Track& track,
                                                      const sim::TriangleMesh& world);

}  // namespace rali::tunnel
