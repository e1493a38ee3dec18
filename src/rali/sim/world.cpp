#include "rali/sim/world.hpp"

#include <string>

#include <fmt/core.h>

#include "rali/base/assert.hpp"
#include "rali/sim/rounds.hpp"
#include "rali/sim/scenes/scenes.hpp"

namespace rali::sim {

namespace {

World build_scene(Scene scene, std::uint64_t seed) {
  const Rng rng(seed, kSceneNames[static_cast<std::size_t>(scene)]);
  switch (scene) {
    case Scene::kLoop:
      return scenes::loop(rng);
    case Scene::kCorridor:
      return scenes::corridor(rng);
    case Scene::kFloor:
      return scenes::storey(rng);
    case Scene::kYard:
      return scenes::yard(rng);
    case Scene::kGarage:
      return scenes::garage(rng);
    case Scene::kTunnel:
      return scenes::tunnel(rng);
    case Scene::kMine:
      return scenes::mine(rng);
    case Scene::kRamp:
      return scenes::ramp(rng);
    case Scene::kHall:
      return scenes::hall(rng);
    case Scene::kWarehouse:
      return scenes::warehouse(rng);
  }
  RALI_ASSERT(!"every scene has a builder");
  return {};
}

/// Number of vehicles that a scene is made for.
int vehicles_of(Scene scene) {
  if (scene == Scene::kCorridor) return 2;
  return scene == Scene::kFloor ? 3 : 1;
}

}  // namespace

World make_world(Scene scene, std::uint64_t seed) {
  auto world = world_for(build_scene(scene, seed), vehicles_of(scene));
  RALI_ASSERT(world.has_value());  // the routes of all shipped scenes are long enough
  return std::move(*world);
}

Result<World> world_for(const World& scene, int vehicles) {
  if (vehicles < 1 || vehicles > kVehiclesMax) {
    return fail(ErrorCode::kUsage, "vehicles",
                fmt::format("is {}; a world takes 1 to {}", vehicles, kVehiclesMax));
  }
  World world = scene;
  if (static_cast<int>(scene.starts.size()) == vehicles && !scene.rounds.empty()) return world;
  auto plan = plan_rounds(scene, vehicles);
  if (!plan) return tl::make_unexpected(std::move(plan.error()));
  world.starts = std::move(plan->starts);
  world.rounds = std::move(plan->rounds);
  return world;
}

Result<Scene> scene_of(std::string_view name) {
  std::string known;
  for (std::size_t i = 0; i < kSceneNames.size(); ++i) {
    if (kSceneNames[i] == name) return static_cast<Scene>(i);
    known += (i == 0 ? "" : ", ") + std::string(kSceneNames[i]);
  }
  return fail(ErrorCode::kUsage, {}, "there is no scene \"" + std::string(name) + "\"",
              "The scenes are " + known + ".");
}

}  // namespace rali::sim
