#pragma once

#include <string_view>

#include "rali/base/result.hpp"
#include "rali/base/settings.hpp"
#include "rali/sim/mesh.hpp"

namespace rali::sim {

enum class Scene { kLoop, kCorridor, kFloor, kYard, kGarage, kTunnel, kMine, kRamp };
inline constexpr ChoiceNames<8> kSceneNames{"loop",   "corridor", "floor", "yard",
                                            "garage", "tunnel",   "mine",  "ramp"};

/// A place and a way through it. World frame: z up, the route starts near the origin.
struct World {
  TriangleMesh mesh;
  std::vector<geometry::Vec3> route;  ///< corners of the way, on the ground
  double rounding_m = 1.2;            ///< over which its corners are cut
  double free_width_m = 1.0;          ///< clear ground on each side of the route, for pedestrians
};

/// Builds a scene; another seed gives another place of the same kind.
[[nodiscard]] World make_world(Scene scene, std::uint64_t seed);

/// The scene of that name, or an error that lists the names.
[[nodiscard]] Result<Scene> scene_of(std::string_view name);

}  // namespace rali::sim
