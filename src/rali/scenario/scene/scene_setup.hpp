#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/scenario/scene/plan_source.hpp"
#include "rali/sim/fleet/fleet_simulation.hpp"
#include "rali/sim/tunnels/tunnels.hpp"
#include "rali/sim/world.hpp"

namespace rali::scenario {

/// Source of the world, selected by the key of scene.yaml with this name.
enum class PlaceKind { kScene, kFloorPlan, kTunnel, kMine, kRamp, kMesh };
inline constexpr ChoiceNames<6> kPlaceNames{"scene", "floor_plan", "tunnel",
                                            "mine",  "ramp",       "mesh"};

enum class UpAxis { kZ, kY, kX };
inline constexpr ChoiceNames<3> kUpNames{"z", "y", "x"};

enum class LengthUnit { kMetre, kCentimetre, kMillimetre, kInch, kFoot };
inline constexpr ChoiceNames<5> kUnitNames{"m", "cm", "mm", "in", "ft"};

/// A world from a file.
struct MeshSource {
  std::string file;  ///< path that this process can open
  LengthUnit units = LengthUnit::kMetre;
  double scale = 1.0;  ///< applied after the units
  UpAxis up = UpAxis::kZ;
  double reflectivity = 0.5;  ///< for files without reflectivity
};

/// One vehicle of a scene; world_of() determines what is not given.
struct SceneVehicle {
  /// NaN x: not given; NaN z: on the ground.
  geometry::Vec3 start = geometry::Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  std::optional<double> yaw_deg;      ///< not given: towards the first point of its path
  std::vector<geometry::Vec3> route;  ///< its path in the only round, if there are no rounds
  geometry::Vec3 goal = geometry::Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  std::string where;        ///< file:line
  std::string start_where;  ///< file:line
  std::string path_where;   ///< file:line of route or goal

  template <class V>
  void visit(V& v) {
    v.custom("start", noting(place(start), start_where), "x, y and maybe z");
    v.custom("yaw_deg", config::number_or(yaw_deg, "auto", -360.0, 360.0), "heading at the start");
    v.custom("route", noting(path(route), path_where), "its way");
    v.custom("goal", noting(place(goal), path_where), "instead of a route: it finds a way there");
  }
};

/// A round as written in scene.yaml, vehicles by number.
struct SceneRound {
  int anchor = -1;
  std::optional<double> pause_s;  ///< standstill before it; not given: pause_s of the scene
  std::vector<std::vector<geometry::Vec3>> routes;  ///< by vehicle
  std::vector<std::string> route_where;             ///< by vehicle
  std::string where;
};

/// A scene as written in scene.yaml (docs/reference/scenes.md), with all values present.
struct SceneSetup {
  PlaceKind place = PlaceKind::kScene;
  sim::Scene scene = sim::Scene::kCorridor;
  PlanSource floor_plan;
  sim::TunnelOptions tunnel;
  sim::MineOptions mine;
  sim::RampOptions ramp;
  MeshSource mesh;
  std::vector<SceneVehicle> vehicles;  ///< empty: fleet.vehicles as placed by the scene
  std::vector<SceneRound> rounds;      ///< empty: from routes, goals or the scene
  /// Seed, duration, sensors, motion, radios and the number of vehicles.
  sim::FleetOptions fleet;
  std::string name;                  ///< of the file, for messages
  std::string folder;                ///< of the file, for relative paths
  std::vector<std::string> notices;  ///< one sentence for each key with an old name
};

/// A shipped scene with the number of vehicles it is made for.
[[nodiscard]] SceneSetup shipped_scene(sim::Scene scene, std::uint64_t seed);

/// Number of vehicles that a shipped scene is made for.
[[nodiscard]] int vehicles_of(sim::Scene scene);

/// Name of vehicle `index` in files: v1, v2, ...
[[nodiscard]] std::string vehicle_name(int index);

/// Reads scene.yaml. Its relative paths are relative to its folder.
/// Errors: kUsage with file and line of invalid content; kInput if it cannot be read.
[[nodiscard]] Result<SceneSetup> load_scene(const std::string& path);

/// The same from memory; `name` is for messages, `folder` for relative paths.
[[nodiscard]] Result<SceneSetup> parse_scene(std::string_view text, const std::string& name,
                                             const std::string& folder);

/// The effective scene as scene.yaml; parse_scene() of it gives the same scene. File paths are
/// relative to `folder`.
[[nodiscard]] std::string dump_scene(const SceneSetup& setup, const std::string& folder);

/// Builds the world and determines and checks starts and rounds for fleet.vehicles vehicles. Pass
/// the result and setup.fleet to make_fleet_simulation().
/// Errors (kUsage, with file and line where the scene came from a file): a vehicle inside a wall,
/// without ground, or on another one; a route through a wall; no path to a goal; a world larger
/// than 20 km or with more than 20 million triangles; those of the world's own kind. kInput: a mesh
/// file that cannot be read.
[[nodiscard]] Result<sim::World> world_of(const SceneSetup& setup);

}  // namespace rali::scenario
