#include "place.hpp"

#include <filesystem>
#include <utility>

#include "rali/scenario/scene/scene_setup.hpp"

namespace rali::fleet_bench {

namespace {

Result<scenario::SceneSetup> setup_of(const Place& place) {
  if (from_file(place)) return scenario::load_scene(place.scene);
  const auto scene = sim::scene_of(place.scene);
  if (!scene) return tl::make_unexpected(scene.error());
  return scenario::shipped_scene(*scene, place.seed);
}

}  // namespace

bool from_file(const Place& place) {
  return std::filesystem::path(place.scene).extension() == ".yaml";
}

Result<PlaceWorld> world_of(const Place& place) {
  auto setup = setup_of(place);
  if (!setup) return tl::make_unexpected(setup.error());
  sim::FleetOptions& fleet = setup->fleet;
  if (place.vehicles > 0) fleet.vehicles = place.vehicles;
  if (place.halves) fleet.vehicles = 1;
  fleet.radio_link = false;
  fleet.vehicle.seed = place.seed;
  fleet.vehicle.pedestrians = place.pedestrians;
  fleet.vehicle.duration_s = place.duration_s;
  fleet.vehicle.imu_apart = true;  // as on real vehicles
  auto world = scenario::world_of(*setup);
  if (!world) return tl::make_unexpected(world.error());
  PlaceWorld out{std::move(*world), fleet, {}};
  if (from_file(place)) out.scene = scenario::dump_scene(*setup, setup->folder);
  return out;
}

std::string name_of(const Place& place) {
  return from_file(place) ? std::filesystem::path(place.scene).stem().string() : place.scene;
}

}  // namespace rali::fleet_bench
