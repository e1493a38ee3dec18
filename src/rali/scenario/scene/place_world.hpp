#pragma once

#include "rali/scenario/scene/scene_setup.hpp"

namespace rali::scenario {

/// The world without vehicles: mesh, and the path of a single vehicle where the kind of world
/// defines one. Errors as world_of().
[[nodiscard]] Result<sim::World> place_world(const SceneSetup& setup);

/// Adds plan.clutter boxes to the free space of a floor plan, away from `paths` and doors.
void add_clutter(const PlanSource& plan, const std::vector<std::vector<geometry::Vec3>>& paths,
                 std::uint64_t seed, sim::TriangleMesh& mesh);

}  // namespace rali::scenario
