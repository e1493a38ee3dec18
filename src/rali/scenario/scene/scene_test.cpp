#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "rali/io/files/mesh_file.hpp"
#include "rali/io/files/test_folder.hpp"
#include "rali/scenario/scene/scene_setup.hpp"
#include "rali/sim/clearance.hpp"
#include "rali/sim/floor_plan/floor_plan.hpp"

namespace rali::scenario {
namespace {

using geometry::Vec3;

/// Two rooms, a door at (5.1, 2), a pillar at (2, 3).
const std::string kRooms =
    "floor_plan:\n"
    "  areas:\n"
    "    - {rectangle: [0, 0, 5, 4]}\n"
    "    - {polygon: [[5.2, 0], [10, 0], [10, 4], [5.2, 4], [5.2, 0]], walls: brick}\n"
    "  doors:\n"
    "    - {at: [5.1, 2], depth_m: 0.2, width_m: 1.0}\n"
    "  pillars:\n"
    "    - {at: [2, 3.2], radius_m: 0.2}\n";

Result<sim::World> world_from(const std::string& text, const std::string& folder = "") {
  const auto setup = parse_scene(text, "scene.yaml", folder);
  if (!setup) return tl::make_unexpected(setup.error());
  return world_of(*setup);
}

std::string error_of(const std::string& text, const std::string& folder = "") {
  const auto world = world_from(text, folder);
  return world ? std::string("no error") : world.error().message();
}

TEST(Scene, a_shipped_scene_equals_the_output_of_make_world) {
  const auto world = world_from("schema: 1\nscene: corridor\nseed: 3\n");
  ASSERT_TRUE(world) << world.error().message();
  const sim::World expected = sim::make_world(sim::Scene::kCorridor, 3);
  EXPECT_EQ(world->mesh.vertices, expected.mesh.vertices);
  EXPECT_EQ(world->starts.size(), 2U);
  EXPECT_EQ(world->rounds.size(), expected.rounds.size());
  const auto setup =
      parse_scene("scene: floor\nvehicles: 5\nseed: 18446744073709551615\n", "s", "");
  ASSERT_TRUE(setup);
  EXPECT_EQ(setup->fleet.vehicle.seed, 18446744073709551615ULL);
  EXPECT_EQ(setup->fleet.vehicles, 5);
  EXPECT_EQ(world_of(*setup)->starts.size(), 5U);
}

TEST(Scene, every_shipped_scene_is_unchanged_after_dump_and_parse) {
  for (std::size_t i = 0; i < sim::kSceneNames.size(); ++i) {
    const SceneSetup setup = shipped_scene(static_cast<sim::Scene>(i), 2);
    const auto again = parse_scene(dump_scene(setup, ""), "scene.yaml", "");
    ASSERT_TRUE(again) << again.error().message();
    EXPECT_EQ(again->fleet.vehicles, setup.fleet.vehicles);
    EXPECT_EQ(world_of(*again)->mesh.vertices, world_of(setup)->mesh.vertices);
  }
}

TEST(Scene, vehicles_drive_the_routes_that_the_file_gives) {
  const auto world = world_from(kRooms +
                                "vehicles:\n"
                                "  - {start: [1, 2], route: [[1, 2], [8, 2]]}\n"
                                "  - {start: [1, 1], yaw_deg: 90}\n"
                                "  - {start: [3, 1], goal: [8, 3]}\n");
  ASSERT_TRUE(world) << world.error().message();
  ASSERT_EQ(world->starts.size(), 3U);
  ASSERT_EQ(world->rounds.size(), 1U);
  EXPECT_NEAR(world->starts[1].yaw_rad, M_PI / 2.0, 1e-9);
  EXPECT_NEAR(world->starts[0].yaw_rad, 0.0, 1e-6);
  const auto& routes = world->rounds[0].routes;
  EXPECT_NEAR(routes[0].back().x(), 8.0, 1e-9);
  EXPECT_TRUE(routes[1].empty());
  EXPECT_NEAR((routes[2].back() - Vec3(8.0, 3.0, 0.0)).norm(), 0.0, 1e-6);
  EXPECT_FALSE(sim::Clearance(world->mesh).first_contact(routes[2], {}));
}

TEST(Scene, routes_of_rounds_start_at_the_current_vehicle_position) {
  const auto world = world_from(kRooms +
                                "vehicles:\n  - {start: [1, 2]}\n  - {start: [1, 1]}\n"
                                "rounds:\n"
                                "  - {anchor: v2, routes: {v1: [[4, 2], [8, 2]]}}\n"
                                "  - {anchor: v1, routes: {v2: [[4, 1.8], [7, 1.9]]}}\n");
  ASSERT_TRUE(world) << world.error().message();
  ASSERT_EQ(world->rounds.size(), 2U);
  EXPECT_EQ(world->rounds[0].anchor, 1);
  EXPECT_EQ(world->rounds[0].routes[0].front(), Vec3(1.0, 2.0, 0.0));
  EXPECT_EQ(world->rounds[1].routes[1].front(), Vec3(1.0, 1.0, 0.0));
}

TEST(Scene, rounds_of_a_shipped_scene_use_its_default_vehicles) {
  const auto world = world_from("scene: corridor\nrounds:\n  - {anchor: v2}\n  - {anchor: v1}\n");
  ASSERT_TRUE(world) << world.error().message();
  ASSERT_EQ(world->rounds.size(), 2U);
  EXPECT_EQ(world->rounds[0].anchor, 1);
  for (const sim::RoundPlan& round : world->rounds) EXPECT_EQ(round.routes.size(), 2U);
}

TEST(Scene, rounds_allow_more_vehicles_but_not_fewer) {
  auto setup = parse_scene("scene: corridor\nvehicles: 2\nrounds:\n  - {anchor: v2}\n", "s", "");
  ASSERT_TRUE(setup) << setup.error().message();
  setup->fleet.vehicles = 3;
  const auto more = world_of(*setup);
  ASSERT_TRUE(more) << more.error().message();
  EXPECT_EQ(more->rounds[0].routes.size(), 3U);
  setup->fleet.vehicles = 1;
  const auto fewer = world_of(*setup);
  ASSERT_FALSE(fewer);
  EXPECT_EQ(fewer.error().message(),
            "s:4: a round names v2, but vehicles is 1. Ask for more vehicles, or take it "
            "out of the rounds.");
}

TEST(Scene, a_floor_plan_without_routes_gets_a_path_through_its_rooms) {
  const auto world = world_from(kRooms + "vehicles: 2\n");
  ASSERT_TRUE(world) << world.error().message();
  EXPECT_EQ(world->starts.size(), 2U);
  double low = 1e9;
  double high = -1e9;
  for (const Vec3& p : world->route) {
    low = std::min(low, p.x());
    high = std::max(high, p.x());
    EXPECT_NEAR(p.z(), 0.0, 0.01);
  }
  EXPECT_LT(low, 2.0);
  EXPECT_GT(high, 8.0);
}

TEST(Scene, clutter_depends_on_the_seed_and_stays_off_the_routes) {
  const std::string text =
      "floor_plan: {areas: [{rectangle: [0, 0, 12, 8]}], clutter: 6}\n"
      "vehicles: [{start: [1, 1], route: [[1, 1], [11, 1]]}]\nseed: ";
  const auto one = world_from(text + "1\n");
  const auto two = world_from(text + "2\n");
  ASSERT_TRUE(one) << one.error().message();
  EXPECT_EQ(one->mesh.triangles.size(), 12U + 6 * 12U);
  EXPECT_NE(one->mesh.vertices, two->mesh.vertices);
  EXPECT_FALSE(sim::Clearance(one->mesh).first_contact(one->rounds[0].routes[0], {}));
}

TEST(Scene, parametric_tunnel_mine_and_ramp_are_built) {
  const auto tunnel = world_from("tunnel: {length_m: 500, gradient: 0.02}\nvehicles: 3\n");
  ASSERT_TRUE(tunnel) << tunnel.error().message();
  EXPECT_NEAR(tunnel->route.back().z() - tunnel->route.front().z(), 492.0 * 0.02, 0.1);
  EXPECT_EQ(tunnel->starts.size(), 3U);
  EXPECT_TRUE(world_from("mine: {length_m: 60}\n"));
  EXPECT_TRUE(world_from("ramp: {turns: 1}\n"));
}

TEST(Scene, a_vehicle_in_a_sloping_tunnel_starts_on_the_ground) {
  const auto world = world_from(
      "tunnel: {length_m: 300, gradient: 0.05}\n"
      "vehicles: [{start: [200, 0], route: [[200, 0], [220, 0]]}]\n");
  ASSERT_TRUE(world) << world.error().message();
  const auto down = world_from(
      "tunnel: {length_m: 300, gradient: -0.05}\n"
      "vehicles: [{start: [200, 0], route: [[200, 0], [220, 0]]}]\n");
  ASSERT_TRUE(down) << down.error().message();
  EXPECT_NEAR(down->starts[0].p_world_m.z(), -10.0, 0.1);
  EXPECT_NEAR(world->starts[0].p_world_m.z(), 10.0, 0.1);
  EXPECT_NEAR(world->rounds[0].routes[0].back().z(), 11.0, 0.1);
}

/// The two rooms as a mesh file in millimetres with y up.
void write_rooms(const std::string& path) {
  sim::FloorPlan plan;
  plan.areas = {{sim::rectangle(0.0, 0.0, 5.0, 4.0), 2.6, 0.6},
                {sim::rectangle(5.0, 1.0, 9.0, 3.0), 2.6, 0.6}};
  sim::TriangleMesh mesh = sim::floor_plan_mesh(plan).value();
  for (geometry::Vec3f& v : mesh.vertices) v = 1000.0F * geometry::Vec3f(v.x(), v.z(), -v.y());
  ASSERT_TRUE(io::write_mesh_ply(path, mesh.vertices, mesh.triangles, mesh.reflectivity));
}

TEST(Scene, a_mesh_file_in_millimetres_with_y_up_is_converted) {
  const io::TestFolder folder;
  write_rooms(folder.path("rooms.ply"));
  const std::string text =
      "mesh: {file: rooms.ply, units: mm, up: y}\nvehicles: [{start: [1, 1]}]\n";
  const auto world = world_from(text, folder.path());
  ASSERT_TRUE(world) << world.error().message();
  EXPECT_NEAR(world->mesh.upper_corner().x(), 9.0, 1e-5);
  EXPECT_NEAR(world->mesh.upper_corner().z(), 2.6, 1e-5);
  // The path leads to the far end of the other room.
  EXPECT_GT(world->rounds.at(0).routes[0].back().x(), 8.0);
  // In metres it is 9 km long with a floor of 1 km square: too large to plan paths, not for walls.
  const auto giant =
      world_from("mesh: {file: rooms.ply, up: y}\nvehicles: [{start: [1, 1]}]\n", folder.path());
  ASSERT_FALSE(giant);
  EXPECT_NE(giant.error().message().find("too large to plan paths"), std::string::npos);
}

TEST(Scene, the_effective_scene_reads_back_as_the_same_scene) {
  const std::string text = kRooms +
                           "  recesses: [{at: [0, 2], yaw_deg: 180, depth_m: 0.1}]\n"
                           "  furniture: [{at: [9, 1], size_m: [1, 0.6, 0.75], material: steel}]\n"
                           "  materials: {felt: 0.11}\n  walls: felt\n"
                           "vehicles:\n  - {start: [1, 2], route: [[1, 2], [8, 2]]}\n"
                           "  - {start: [1, 1, 0], yaw_deg: 12.5}\n"
                           "lidar: os1_64\nmotion: {speed_mps: 0.8}\nuwb: {rate_hz: 10}\n";
  const auto setup = parse_scene(text, "scene.yaml", "");
  ASSERT_TRUE(setup) << setup.error().message();
  const std::string dumped = dump_scene(*setup, "");
  const auto again = parse_scene(dumped, "again.yaml", "");
  ASSERT_TRUE(again) << again.error().message() << "\n" << dumped;
  EXPECT_EQ(dump_scene(*again, ""), dumped);
  const auto first = world_of(*setup);
  const auto second = world_of(*again);
  ASSERT_TRUE(first) << first.error().message();
  ASSERT_TRUE(second) << second.error().message();
  EXPECT_EQ(first->mesh.vertices, second->mesh.vertices);
  EXPECT_EQ(first->mesh.reflectivity, second->mesh.reflectivity);
  EXPECT_EQ(first->rounds[0].routes, second->rounds[0].routes);
  EXPECT_EQ(again->fleet.vehicle.motion.speed_mps, 0.8);
}

TEST(Scene, wrong_keys_are_refused_with_a_suggestion) {
  EXPECT_EQ(error_of("scene: corridor\nseeed: 1\n"),
            "scene.yaml:2: unknown key 'seeed'. Did you mean 'seed'?");
  EXPECT_EQ(error_of("floorplan: {}\n"),
            "scene.yaml:1: unknown key 'floorplan'. Did you mean 'floor_plan'?");
  EXPECT_EQ(error_of("seed: 1\n"),
            "scene.yaml: does not say what the place is. Give one of scene, floor_plan, tunnel, "
            "mine, ramp, mesh.");
  EXPECT_EQ(error_of("scene: loop\ntunnel: {}\n"),
            "scene.yaml:2: both scene and tunnel are given. A scene has one place: remove one of "
            "them.");
  EXPECT_EQ(error_of("floor_plan:\n  areas:\n    - {rectangel: [0, 0, 1, 1]}\n"),
            "scene.yaml:3: unknown key 'rectangel'. Did you mean 'rectangle'?");
  EXPECT_EQ(error_of("schema: 2\nscene: loop\n"),
            "scene.yaml:1: schema is 2; this version reads schema 1.");
  EXPECT_EQ(error_of("scene: lopo\n").find("scene.yaml:1: scene is lopo; allowed is loop"), 0U);
  EXPECT_EQ(error_of("scene: loop\nvehicles: 11\n"),
            "scene.yaml:2: 11 vehicles; a scene takes 1 to 10.");
  EXPECT_EQ(error_of("tunnel: {length_m: .nan}\n").find("scene.yaml:1: tunnel.length_m"), 0U);
  EXPECT_EQ(error_of("tunnel: {length_m: 1e9}\n").find("scene.yaml:1: tunnel.length_m"), 0U);
}

TEST(Scene, invalid_polygons_are_refused_with_their_line) {
  const auto polygon = [](const std::string& corners) {
    return error_of("floor_plan:\n  areas:\n    - {rectangle: [0, 0, 1, 1]}\n    - {polygon: " +
                    corners + "}\n");
  };
  EXPECT_EQ(polygon("[[0, 0], [4, 0], [4, 3], [0, 3]]"),
            "scene.yaml:4: floor_plan.areas.polygon is open: it ends at [0, 3], not at its first "
            "corner [0, 0]. Repeat the first corner at the end.");
  EXPECT_EQ(polygon("[[0, 0], [4, 3], [4, 0], [0, 3], [0, 0]]"),
            "scene.yaml:4: floor_plan.areas.polygon crosses itself: the edges from [0, 0] and "
            "[4, 0] meet.");
  EXPECT_EQ(
      polygon("[[0, 0], [4, 0], [0, 0]]"),
      "scene.yaml:4: floor_plan.areas.polygon has 3 corners; it needs 3, and the first again.");
  EXPECT_EQ(polygon("[[0, 0], [4, .nan], [4, 4], [0, 0]]")
                .find("scene.yaml:4: floor_plan.areas.polygon is a list of 2; allowed is a point"),
            0U);
  EXPECT_EQ(polygon("[[0, 0], [1e9, 0], [4, 4], [0, 0]]").find("scene.yaml:4:"), 0U);
  EXPECT_EQ(error_of("floor_plan:\n  areas:\n    - {rectangle: [3, 0, 1, 1]}\n")
                .find("scene.yaml:3: the area [3, 0, 1, 1] is empty"),
            0U);
  EXPECT_EQ(error_of("floor_plan: {areas: []}\n").find("scene.yaml: floor_plan: has no areas"), 0U);
  EXPECT_EQ(error_of("floor_plan:\n  areas:\n    - {rectangle: [0, 0, 5, 5], walls: brik}\n"),
            "scene.yaml:3: there is no material brik. Did you mean 'brick'?");
}

TEST(Scene, vehicles_without_free_space_are_refused_with_their_line) {
  EXPECT_EQ(error_of(kRooms + "vehicles:\n  - {start: [0.2, 2]}\n"),
            "scene.yaml:10: v1 stands in a wall or too near to one at [0.20, 2.00]: it needs "
            "0.30 m, there are 0.20 m. Move it into free space.");
  EXPECT_EQ(error_of(kRooms + "vehicles:\n  - {start: [1, 1]}\n  - {start: [2.1, 3.2]}\n")
                .find("scene.yaml:11: v2 stands in a wall or too near to one at [2.10, 3.20]"),
            0U);
  EXPECT_EQ(error_of(kRooms + "  furniture: [{at: [1, 1], size_m: [1, 1, 0.75]}]\n"
                              "vehicles:\n  - {start: [1, 1]}\n")
                .find("scene.yaml:11: v1 stands in a wall"),
            0U);
  EXPECT_EQ(error_of(kRooms + "vehicles:\n  - {start: [-3, 2]}\n"),
            "scene.yaml:10: v1 has no ground below it at [-3.00, 2.00]. Put it inside the free "
            "space.");
  EXPECT_EQ(error_of(kRooms + "vehicles:\n  - {start: [1, 1]}\n  - {start: [1.3, 1]}\n"),
            "scene.yaml:11: v1 and v2 are 0.30 m apart at the start; they need 0.60 m.");
  EXPECT_EQ(error_of(kRooms + "vehicles:\n  - {yaw_deg: 3}\n"),
            "scene.yaml:10: v1 has neither start nor route. Give `start: [x, y]`.");
}

TEST(Scene, routes_through_walls_are_refused_with_their_line) {
  const std::string through =
      error_of(kRooms + "vehicles:\n  - start: [1, 1]\n    route: [[1, 1], [8, 1]]\n");
  EXPECT_EQ(through.find("scene.yaml:11: the path of v1 "), 0U) << through;
  EXPECT_EQ(error_of(kRooms + "vehicles:\n  - start: [1, 3.2]\n    route: [[1, 3.2], [4, 3.2]]\n")
                .find("scene.yaml:11: the path of v1 touches a wall at [1."),
            0U);
  EXPECT_EQ(error_of(kRooms + "vehicles:\n  - {start: [1, 2]}\n  - {start: [1, 1]}\nrounds:\n"
                              "  - anchor: v2\n    routes:\n      v1: [[3, 2], [3, 9]]\n")
                .find("scene.yaml:15: the path of v1 has no ground at [3.00, 4."),
            0U);
  EXPECT_EQ(error_of(kRooms + "vehicles:\n  - {start: [1, 1], goal: [-1, 1]}\n")
                .find("scene.yaml:10: v1's goal has no ground"),
            0U);
  EXPECT_EQ(error_of(kRooms + "vehicles:\n  - {start: [1, 2]}\n  - {start: [1, 1]}\nrounds:\n"
                              "  - {anchor: v3}\n"),
            "scene.yaml:13: v3 is no vehicle of this scene. Known here: v1, v2.");
  EXPECT_EQ(error_of(kRooms + "vehicles:\n  - {start: [1, 2]}\n  - {start: [1, 1]}\nrounds:\n"
                              "  - {anchor: v1, routes: {v1: [[1, 2], [3, 2]]}}\n"),
            "scene.yaml:13: v1 is the anchor of this round, so it has no way.");
}

TEST(Scene, goals_without_a_path_are_refused_with_their_line) {
  EXPECT_EQ(error_of("floor_plan:\n  areas:\n    - {rectangle: [0, 0, 4, 4]}\n"
                     "    - {rectangle: [5, 0, 9, 4]}\n"
                     "vehicles: [{start: [1, 1], goal: [8, 1]}]\n")
                .find("scene.yaml:5: there is no path from [1.00, 1.00] to [8.00, 1.00]"),
            0U);
}

TEST(Scene, unusable_mesh_files_are_refused_with_a_reason) {
  const io::TestFolder folder;
  const std::string mesh = "mesh: {file: a.obj}\nvehicles: [{start: [1, 1]}]\n";
  EXPECT_NE(error_of(mesh, folder.path()).find("a.obj"), std::string::npos);
  (void)folder.write("a.obj", "v 0 0 0\n");
  EXPECT_NE(error_of(mesh, folder.path()).find("a.obj: the mesh has no triangles"),
            std::string::npos);
  (void)folder.write("a.obj", "v 0 0 0\nv 9e5 0 0\nv 0 9e5 0\nf 1 2 3\n");
  EXPECT_EQ(error_of(mesh, folder.path()),
            "scene.yaml: the world reaches 900000 m from the origin; at most 20000 m are possible. "
            "Check mesh.units and mesh.scale.");
  (void)folder.write("a.obj", "v 0 0 0\nv 9 0 0\nv 0 9 0\nf 1 2 3\n");
  EXPECT_EQ(error_of("mesh: {file: a.obj}\n", folder.path()),
            "scene.yaml: a mesh does not say where a vehicle starts. Give `vehicles: [{start: "
            "[x, y]}]`.");
  EXPECT_EQ(error_of("mesh: {units: mm}\n"),
            "scene.yaml:1: mesh names no file. Give `mesh: {file: NAME}`, a .ply, .obj or .stl "
            "file.");
}

TEST(Scene, a_missing_scene_file_is_named_in_the_error) {
  const auto setup = load_scene("/nowhere/scene.yaml");
  ASSERT_FALSE(setup);
  EXPECT_EQ(setup.error().message(), "/nowhere/scene.yaml: cannot be opened.");
}

TEST(Scene, a_truncated_scene_file_is_read_or_refused) {
  const std::string text = kRooms + "vehicles: [{start: [1, 2], route: [[1, 2], [8, 2]]}]\n";
  for (std::size_t n = 0; n < text.size(); ++n) {
    const auto setup = parse_scene(text.substr(0, n), "scene.yaml", "");
    if (!setup) {
      EXPECT_FALSE(setup.error().where.empty()) << n;
      EXPECT_EQ(setup.error().message().find('\n'), std::string::npos) << n;
    }
  }
}

}  // namespace
}  // namespace rali::scenario
