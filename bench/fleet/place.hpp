#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "rali/sim/fleet/fleet_simulation.hpp"

namespace rali::fleet_bench {

/// All options that affect the measurements and messages of the vehicles.
struct Place {
  std::string scene;  ///< shipped, or a .yaml file (docs/reference/scenes.md)
  std::uint64_t seed = 1;
  int vehicles = 0;  ///< 0: as many as the scene is made for
  int pedestrians = 6;
  double duration_s = 0.0;  ///< 0: all rounds
  /// The recording of one vehicle is cut into two that overlap, as if of two vehicles and days.
  bool halves = false;
  bool known = false;                 ///< the vehicles also get start poses, as measured by hand
  double common = 0.2;                ///< fraction of the recording's time that is in both parts
  std::vector<std::string> settings;  ///< key=value for the vehicles
};

/// A world with starts for its vehicles, and the fleet's options.
struct PlaceWorld {
  sim::World world;
  sim::FleetOptions options;
  std::string scene;  ///< effective scene.yaml of a scene loaded from a file
};

[[nodiscard]] bool from_file(const Place& place);

/// Errors (kUsage): no such scene, too many vehicles; of the file.
[[nodiscard]] Result<PlaceWorld> world_of(const Place& place);

/// The scene's name, or that of its file without folder and extension.
[[nodiscard]] std::string name_of(const Place& place);

}  // namespace rali::fleet_bench
