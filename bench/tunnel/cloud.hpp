#pragma once

#include "rali/eval/cloud_to_mesh.hpp"
#include "run.hpp"

namespace rali::tunnel {

/// Distances of the map's points to the surfaces of the world. The map is built as by `rali map`
/// from the smoothed keyframes and aligned to the world by the trajectory, then by its own points.
/// Errors: of map::build_map() and eval::align_to_mesh().
[[nodiscard]] Result<eval::CloudToMesh> compare_cloud(const Track& track,
                                                      const sim::TriangleMesh& world);

}  // namespace rali::tunnel
