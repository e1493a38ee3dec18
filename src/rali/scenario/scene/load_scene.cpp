#include <algorithm>
#include <array>
#include <filesystem>

#include <fmt/format.h>

#include "rali/config/apply.hpp"
#include "rali/config/suggest.hpp"
#include "rali/config/text_of.hpp"
#include "rali/scenario/scene/old_scene_keys.hpp"
#include "rali/scenario/scene/scene_fields.hpp"
#include "rali/scenario/scene/scene_setup.hpp"

namespace rali::scenario {

using config::Node;

namespace {

constexpr int kSchema = 1;

Status check_schema(const Node& root) {
  const Node* const schema = root.find("schema");
  if (schema == nullptr) return {};
  long long number = 0;
  if (schema->kind == Node::Kind::kScalar && config::parse_integer(schema->text, number) &&
      number == kSchema) {
    return {};
  }
  return fail(ErrorCode::kUsage, schema->where,
              fmt::format("schema {}; this version reads schema {}",
                          config::describe_value(*schema), kSchema));
}

/// The kind of world: exactly one of its keys must be present.
Result<PlaceKind> place_kind(const Node& root, const std::string& name) {
  const Node* first = nullptr;
  PlaceKind kind = PlaceKind::kScene;
  for (std::size_t i = 0; i < kPlaceNames.size(); ++i) {
    const Node* const node = root.find(kPlaceNames[i]);
    if (node == nullptr) continue;
    if (first != nullptr) {
      return fail(ErrorCode::kUsage, node->key_where,
                  fmt::format("both {} and {} are given", first->key, node->key),
                  "A scene has one place: remove one of them.");
    }
    first = node;
    kind = static_cast<PlaceKind>(i);
  }
  if (first != nullptr) return kind;
  // A misspelt key is the most likely cause.
  const std::vector<std::string> places(kPlaceNames.begin(), kPlaceNames.end());
  for (const Node& child : root.children) {
    const std::string near = config::nearest_name(child.key, places);
    if (near.empty()) continue;
    return fail(ErrorCode::kUsage, child.key_where,
                fmt::format("unknown key '{}'", child.key.substr(0, 80)),
                fmt::format("Did you mean '{}'?", near));
  }
  return fail(ErrorCode::kUsage, name, "does not say what the place is",
              "Give one of scene, floor_plan, tunnel, mine, ramp, mesh.");
}

/// The map without one key, which is read separately.
Node without(const Node& root, std::string_view key) {
  Node rest = root;
  std::erase_if(rest.children, [&](const Node& child) { return child.key == key; });
  return rest;
}

/// The map with only one of its keys.
Node only(const Node& root, std::string_view key) {
  Node rest = root;
  std::erase_if(rest.children, [&](const Node& child) { return child.key != key; });
  return rest;
}

/// Moves `vehicles` before `rounds`, since rounds refer to vehicles.
void vehicles_first(Node& root) {
  std::stable_partition(root.children.begin(), root.children.end(),
                        [](const Node& child) { return child.key == "vehicles"; });
}

Result<SceneSetup> scene_from(const Node& file, const std::string& name,
                              const std::string& folder) {
  std::vector<std::string> notices;
  const Node root = with_current_scene_keys(file, notices);
  if (root.kind != Node::Kind::kMap) {
    return fail(ErrorCode::kUsage, root.where, "the file must be a group of keys");
  }
  if (auto status = check_schema(root); !status) return tl::make_unexpected(status.error());
  const auto kind = place_kind(root, name);
  if (!kind) return tl::make_unexpected(kind.error());
  SceneSetup setup;
  setup.place = *kind;
  setup.name = name;
  setup.folder = folder;
  setup.notices = std::move(notices);
  Node rest = without(root, "schema");
  vehicles_first(rest);
  const config::FieldList fields = scene_fields(setup, folder);
  config::Origins origins;
  if (setup.place == PlaceKind::kScene && rest.find("vehicles") == nullptr) {
    // Rounds refer to vehicles, so the scene's number of vehicles must be known before they are
    // read.
    const Node place = only(rest, "scene");
    if (auto status = config::apply_map(place, "", "", fields, origins); !status) {
      return tl::make_unexpected(status.error());
    }
    setup.fleet.vehicles = vehicles_of(setup.scene);
  }
  if (auto status = config::apply_map(rest, "", "", fields, origins); !status) {
    return tl::make_unexpected(status.error());
  }
  setup.fleet.vehicle.scene = setup.scene;
  if (setup.place == PlaceKind::kMesh && setup.mesh.file.empty()) {
    return fail(ErrorCode::kUsage, root.find("mesh")->where, "mesh names no file",
                "Give `mesh: {file: NAME}`, a .ply, .obj or .stl file.");
  }
  return setup;
}

}  // namespace

int vehicles_of(sim::Scene scene) {
  return static_cast<int>(sim::make_world(scene, 1).starts.size());
}

std::string vehicle_name(int index) { return fmt::format("v{}", index + 1); }

SceneSetup shipped_scene(sim::Scene scene, std::uint64_t seed) {
  SceneSetup setup;
  setup.scene = scene;
  setup.fleet.vehicle.seed = seed;
  setup.fleet.vehicle.scene = scene;
  setup.fleet.vehicles = vehicles_of(scene);
  setup.name = "scene " + std::string(sim::kSceneNames[static_cast<std::size_t>(scene)]);
  return setup;
}

Result<SceneSetup> parse_scene(std::string_view text, const std::string& name,
                               const std::string& folder) {
  const auto root = config::parse_yaml(text, name);
  if (!root) return tl::make_unexpected(root.error());
  return scene_from(*root, name, folder);
}

Result<SceneSetup> load_scene(const std::string& path) {
  const auto root = config::parse_yaml_file(path);
  if (!root) return tl::make_unexpected(root.error());
  return scene_from(*root, path, std::filesystem::path(path).parent_path().string());
}

std::string dump_scene(const SceneSetup& setup, const std::string& folder) {
  SceneSetup copy = setup;
  return fmt::format("schema: {}\n{}", kSchema, config::dump_yaml(scene_fields(copy, folder), {}));
}

}  // namespace rali::scenario
