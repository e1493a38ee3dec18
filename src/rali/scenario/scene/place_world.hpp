#pragma once

#include "rali/scenario/scene/scene_setup.hpp"

namespace rali::scenario {

/// The bare place: mesh, and the way of a single vehicle where the kind of place has one. Errors
/// as world_of().
[[nodiscard]] Result<sim::World> place_world(const SceneSetup& setup);

/// Puts plan.clutter boxes into the free space of a floor plan, off `ways` and doors.
void add_clutter(const PlanSource& plan, const std::vector<std::vector<geometry::Vec3>>& ways,
                 std::uint64_t seed, sim::TriangleMesh& mesh);

}  // namespace rali::scenario
