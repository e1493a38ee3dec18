#include "rali/sim/world.hpp"

#include <string>

#include "rali/base/assert.hpp"
#include "rali/sim/scenes/scenes.hpp"

namespace rali::sim {

World make_world(Scene scene, std::uint64_t seed) {
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
  }
  RALI_ASSERT(!"every scene has a builder");
  return {};
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
