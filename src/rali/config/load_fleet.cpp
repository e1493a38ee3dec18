#include "rali/config/load_fleet.hpp"

#include <algorithm>
#include <filesystem>
#include <initializer_list>
#include <utility>

#include <fmt/format.h>

#include "rali/config/apply.hpp"
#include "rali/config/check_fleet.hpp"
#include "rali/config/old_keys.hpp"
#include "rali/config/presets.hpp"
#include "rali/config/text_of.hpp"
#include "rali/config/vehicle_name.hpp"

namespace rali::config {
namespace {

constexpr std::size_t kMaxVehicles = 64;
constexpr std::string_view kSettings = "settings.";

/// Creates the vehicles that the file names, still with default values.
Status make_vehicles(const Node& root, const std::string& name, FleetConfig& config) {
  const Node* const vehicles = root.find("vehicles");
  if (vehicles == nullptr || vehicles->kind != Node::Kind::kMap || vehicles->children.empty()) {
    return fail(ErrorCode::kUsage, vehicles == nullptr ? name : vehicles->where,
                "no vehicle is named", "Write at least `vehicles: {v1: {recording: FILE}}`.");
  }
  if (vehicles->children.size() > kMaxVehicles) {
    return fail(ErrorCode::kUsage, vehicles->where,
                fmt::format("{} vehicles; at most {} are possible", vehicles->children.size(),
                            kMaxVehicles));
  }
  for (const Node& vehicle : vehicles->children) {
    if (!is_vehicle_name(vehicle.key)) {
      return fail(ErrorCode::kUsage, vehicle.key_where,
                  fmt::format("{} is no name of a vehicle", yaml_quoted(vehicle.key.substr(0, 60))),
                  "Use letters, digits, _ and -, at most 32: it becomes the name of files.");
    }
    config.vehicles.emplace_back();
    config.vehicles.back().name = vehicle.key;
  }
  return {};
}

/// The effective preset: of the command line, else of the file, else the default.
Status choose_preset(const Node& root, const std::vector<Node>& assignments,
                     const Overrides& overrides, FleetConfig& config) {
  const auto take = [&](const Node& node, const std::string& origin) -> Status {
    const Node* const preset = node.find("preset");
    if (preset == nullptr) return {};
    FieldList fields = fleet_fields(config, "");
    const auto field = std::find_if(fields.begin(), fields.end(),
                                    [](const Field& f) { return f.key == "preset"; });
    if (Status status = decode_field(*field, *preset); !status) return status;
    config.origins["preset"] = origin.empty() ? preset->where : origin;
    return {};
  };
  if (Status status = take(root, ""); !status) return status;
  for (const Node& assignment : assignments) {
    if (Status status = take(assignment, "command line"); !status) return status;
  }
  if (!overrides.preset.empty()) {
    if (!is_preset(overrides.preset)) {
      return fail(ErrorCode::kUsage, "command line",
                  fmt::format("preset is {}; allowed is {}", yaml_quoted(overrides.preset),
                              preset_names_text()));
    }
    config.preset = overrides.preset;
    config.origins["preset"] = "command line";
  }
  const Result<Node> changes = parse_yaml(preset_yaml(config.preset), "preset " + config.preset);
  if (!changes) return tl::make_unexpected(changes.error());
  const FieldList fields = fleet_fields(config, "");
  const std::string origin = "preset " + config.preset;
  return apply_map(*changes, std::string(kSettings), origin, fields, config.origins);
}

const Node* find_path(const Node& root, std::initializer_list<const char*> path) {
  const Node* node = &root;
  for (const char* const key : path) {
    if (node != nullptr) node = node->find(key);
  }
  return node;
}

/// The effective carrier sets defaults: the file and the command line take precedence over them.
Status choose_carrier(const Node& root, const std::vector<Node>& assignments, FleetConfig& config) {
  const Node* chosen = find_path(root, {"settings", "odometry", "robust", "carrier"});
  for (const Node& assignment : assignments) {
    for (const Node* const node :
         {find_path(assignment, {"settings", "odometry", "robust", "carrier"}),
          find_path(assignment, {"odometry", "robust", "carrier"})}) {
      if (node != nullptr) chosen = node;
    }
  }
  if (chosen == nullptr) return {};
  const FieldList fields = fleet_fields(config, "");
  const auto field = std::find_if(fields.begin(), fields.end(), [](const Field& f) {
    return f.key == "settings.odometry.robust.carrier";
  });
  if (Status status = decode_field(*field, *chosen); !status) return status;
  const std::string origin = "carrier " + chosen->text;
  const Result<Node> changes = parse_yaml(carrier_yaml(chosen->text), origin);
  if (!changes) return tl::make_unexpected(changes.error());
  return apply_map(*changes, std::string(kSettings), origin, fields, config.origins);
}

/// Module names may be used without `settings.` on the command line.
std::string prefix_of_assignment(const Node& assignment, const FieldList& fields) {
  const std::string room = std::string(kSettings) + assignment.children.front().key + '.';
  const bool is_room = std::any_of(fields.begin(), fields.end(), [&](const Field& field) {
    return field.key.compare(0, room.size(), room) == 0;
  });
  return is_room ? std::string(kSettings) : std::string();
}

Status apply_assignments(const std::vector<Node>& assignments, FleetConfig& config) {
  const FieldList fields = fleet_fields(config, "");
  const std::string chosen = config.preset;
  for (const Node& assignment : assignments) {
    const std::string prefix = prefix_of_assignment(assignment, fields);
    const Status status = apply_map(assignment, prefix, "command line", fields, config.origins);
    if (!status) return status;
  }
  config.preset = chosen;  // --preset overrides --set preset=
  return {};
}

Result<FleetConfig> build(Node file, const std::string& name, const std::string& base_dir,
                          const Overrides& overrides) {
  FleetConfig config;
  const Node root = with_current_keys(std::move(file), config.notices);
  std::vector<Node> assignments;
  for (const std::string& text : overrides.assignments) {
    Result<Node> assignment = parse_assignment(text);
    if (!assignment) return tl::make_unexpected(assignment.error());
    assignments.push_back(assignment_with_current_keys(std::move(*assignment), config.notices));
  }
  if (root.kind != Node::Kind::kMap) {
    return fail(ErrorCode::kUsage, root.where, "this is no group of keys",
                "Write at least `vehicles: {v1: {recording: FILE}}`.");
  }
  // A wrong key is reported before a missing vehicle, because it is often the cause.
  if (root.find("vehicles") == nullptr) {
    Origins unused;
    FleetConfig trial;
    trial.vehicles.emplace_back();
    const Status status = apply_map(root, "", "", fleet_fields(trial, base_dir), unused);
    if (!status) return tl::make_unexpected(status.error());
  }
  if (Status status = make_vehicles(root, name, config); !status) {
    return tl::make_unexpected(status.error());
  }
  if (Status status = choose_preset(root, assignments, overrides, config); !status) {
    return tl::make_unexpected(status.error());
  }
  if (Status status = choose_carrier(root, assignments, config); !status) {
    return tl::make_unexpected(status.error());
  }
  const std::string preset = config.preset;
  const std::string preset_origin =
      config.origins.count("preset") > 0 ? config.origins["preset"] : std::string();
  const FieldList fields = fleet_fields(config, base_dir);
  if (Status status = apply_map(root, "", "", fields, config.origins); !status) {
    return tl::make_unexpected(status.error());
  }
  config.preset = preset;
  if (Status status = apply_assignments(assignments, config); !status) {
    return tl::make_unexpected(status.error());
  }
  if (!preset_origin.empty()) config.origins["preset"] = preset_origin;
  if (Status status = check_fleet(config, name, overrides.live); !status) {
    return tl::make_unexpected(status.error());
  }
  return config;
}

std::string name_of_recording(const std::string& input) {
  std::filesystem::path path = std::filesystem::path(input).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();
  return vehicle_name_from(path.stem().string());
}

Node scalar(std::string key, std::string text, const std::string& where) {
  Node node;
  node.kind = Node::Kind::kScalar;
  node.key = std::move(key);
  node.key_where = node.where = where;
  node.text = std::move(text);
  return node;
}

Node map_node(std::string key, const std::string& where) {
  Node node;
  node.kind = Node::Kind::kMap;
  node.key = std::move(key);
  node.key_where = node.where = where;
  return node;
}

}  // namespace

Result<FleetConfig> load_fleet(const std::string& path, const Overrides& overrides) {
  Result<Node> root = parse_yaml_file(path);
  if (!root) return tl::make_unexpected(root.error());
  const std::string dir = std::filesystem::path(path).parent_path().string();
  return build(std::move(*root), path, dir, overrides);
}

Result<FleetConfig> parse_fleet(std::string_view text, const std::string& name,
                                const std::string& base_dir, const Overrides& overrides) {
  Result<Node> root = parse_yaml(text, name);
  if (!root) return tl::make_unexpected(root.error());
  return build(std::move(*root), name, base_dir, overrides);
}

Result<FleetConfig> fleet_of_recordings(const std::vector<std::string>& inputs,
                                        const Overrides& overrides) {
  const std::string where = "command line";
  Node root = map_node("", where);
  Node vehicles = map_node("vehicles", where);
  for (const std::string& input : inputs) {
    Node vehicle = map_node(name_of_recording(input), where);
    if (const Node* const twin = vehicles.find(vehicle.key); twin != nullptr) {
      return fail(
          ErrorCode::kUsage, input, fmt::format("a second recording of the name '{}'", vehicle.key),
          "Rename one, or write a fleet.yaml; the parts of one recording are a list there.");
    }
    const auto calib = std::filesystem::path(input) / "calib.yaml";
    std::error_code error;
    if (std::filesystem::is_regular_file(calib, error)) {
      Result<Node> section = parse_yaml_file(calib.string());
      if (!section) return tl::make_unexpected(section.error());
      if (section->kind != Node::Kind::kMap) {
        return fail(ErrorCode::kUsage, section->where, "this is no vehicle's section");
      }
      for (Node& child : section->children) vehicle.children.push_back(std::move(child));
    }
    if (vehicle.find("recording") == nullptr) {
      vehicle.children.push_back(scalar("recording", input, where));
    }
    vehicles.children.push_back(std::move(vehicle));
  }
  root.children.push_back(std::move(vehicles));
  return build(std::move(root), where, "", overrides);
}

Result<FleetConfig> fleet_of_names(const std::vector<std::string>& names,
                                   const Overrides& overrides) {
  const std::string where = "command line";
  Node root = map_node("", where);
  Node vehicles = map_node("vehicles", where);
  for (const std::string& name : names) vehicles.children.push_back(map_node(name, where));
  root.children.push_back(std::move(vehicles));
  return build(std::move(root), where, "", overrides);
}

std::string dump_fleet(const FleetConfig& config, const std::string& dir) {
  FleetConfig copy = config;
  return dump_yaml(fleet_fields(copy, dir), copy.origins);
}

std::uint64_t hash_fleet(const FleetConfig& config) {
  FleetConfig copy = config;
  return hash_fields(fleet_fields(copy, ""));
}

}  // namespace rali::config
