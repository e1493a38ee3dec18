#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/base/settings.hpp"
#include "rali/sim/mesh.hpp"

namespace rali::sim {

enum class Scene {
  kLoop,
  kCorridor,
  kFloor,
  kYard,
  kGarage,
  kTunnel,
  kMine,
  kRamp,
  kHall,
  kWarehouse
};
inline constexpr ChoiceNames<10> kSceneNames{"loop",   "corridor", "floor", "yard", "garage",
                                             "tunnel", "mine",     "ramp",  "hall", "warehouse"};

/// Largest number of vehicles in one world.
inline constexpr int kVehiclesMax = 10;

/// Pose of a vehicle before the first round.
struct VehicleStart {
  geometry::Vec3 p_world_m = geometry::Vec3::Zero();  ///< on the ground
  double yaw_rad = 0.0;
};

/// One round of the paper: the anchor is stationary, the others drive their paths; the next round
/// begins when all have arrived.
struct RoundPlan {
  int anchor = -1;  ///< index of a vehicle; -1: none has to be stationary
  /// By vehicle: corners of its path on the ground from its current position; empty: it stays.
  std::vector<std::vector<geometry::Vec3>> routes;
  std::optional<double> pause_s = {};  ///< standstill before it; not given: FleetOptions::pause_s
};

/// A world and the paths through it. World frame: z up, the route starts near the origin.
struct World {
  TriangleMesh mesh;
  std::vector<geometry::Vec3> route;  ///< corners of the path of a single vehicle, on the ground
  double rounding_m = 1.2;            ///< distance over which corners are rounded, of all routes
  double free_width_m = 1.0;          ///< clear ground on each side of the route, for pedestrians
  std::vector<VehicleStart> starts;   ///< for as many vehicles as the world is made for
  std::vector<RoundPlan> rounds;      ///< for that number of vehicles; each continues the last
};

/// Builds a scene; another seed gives another scene of the same kind.
/// corridor is made for two vehicles, floor for three, the others for one.
[[nodiscard]] World make_world(Scene scene, std::uint64_t seed);

/// The same scene with starts and rounds for `vehicles` (1..kVehiclesMax). Existing starts and
/// rounds for that number stay; otherwise see rounds.hpp. One vehicle: one round along `route`.
/// Errors (kUsage): number out of range; the route is too short for so many.
[[nodiscard]] Result<World> world_for(const World& scene, int vehicles);

/// The scene with that name, or an error that lists the names.
[[nodiscard]] Result<Scene> scene_of(std::string_view name);

}  // namespace rali::sim
